"""Restitution by angular velocities, and where a block falls: made-up rows, numbers by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from histories import history_of, scene_of

from rockslip import Scene, parse_scene
from solver.results.endings import fallen
from solver.results.impact_rates import rated_by_velocities
from solver.results.rocking import Impact
from solver.types import Array

AT = 0.5
"""Time of the impact, s, on a row."""

T = 0.01 * np.arange(101)
"""Times of the rows, s."""

BY_PEAKS = 0.11
"""What the peaks said of it."""

STACK = ("name = 'low'", "name = 'up'\non = 'low'")
ELASTIC = {"model": "elastic", "young": 1e10, "poisson": 0.2}


def rates() -> Array:
    """From -1 rad/s at the impact, with -2 rad/s2 before, to -0.7 rad/s, with 3 rad/s2 after.

    The rows next to it, in the middle of the impact, say something else.
    """
    found = np.where(T <= AT, -1.0 - 2 * (T - AT), -0.7 + 3 * (T - AT))
    found[50:52] = 9.0
    return np.asarray(found)


def rated(
    scene: Scene,
    *,
    impacts: tuple[float, ...] = (AT,),
    known: float | None = BY_PEAKS,
    **columns: Any,
) -> list[float | None]:
    """Restitution told of impacts of the last block."""
    block = scene.blocks[-1]
    columns |= {f"{block.name}__angular_velocity_rad_s": rates()}
    told = [Impact(time_s=at, restitution=known) for at in impacts]
    found = rated_by_velocities(scene, history_of(scene, T, **columns), block, told)
    assert [impact.time_s for impact in found] == list(impacts)
    return [impact.restitution for impact in found]


def made_elastic(scene: Scene, number: int) -> Scene:
    """The scene with one of its blocks elastic."""
    tables = scene.to_dict()
    tables["block"][number] |= ELASTIC
    return parse_scene(tables)


def shaken() -> Scene:
    """A block on ground that moves."""
    return scene_of("", rest="[motion]\nkind = 'half_sine'\namplitude_g = 0.1\nduration = 0.9\n")


SWAYS = {"low__angle_rad": 0.01 * np.sin(np.pi * T) * (T < 1)}


def test_rates_are_those_of_lines_through_rows_beside_the_impact() -> None:
    assert rated(scene_of(*STACK), **SWAYS) == pytest.approx([0.7])


def test_a_carrier_that_swayed_and_stands_again_does_not_hold() -> None:
    assert rated(scene_of(*STACK)) == [BY_PEAKS]
    assert SWAYS["low__angle_rad"][-1] == 0
    assert rated(scene_of(*STACK), **SWAYS) != [BY_PEAKS]


def test_a_carrier_on_one_that_moves_does_not_hold() -> None:
    scene = scene_of("name = 'ground'", "name = 'low'\non = 'ground'", "name = 'up'\non = 'low'")
    assert rated(scene) == [BY_PEAKS]
    assert rated(scene, ground__slip_m=0.01 * T) == pytest.approx([0.7])


@pytest.mark.parametrize("number", [0, 1])
def test_vibration_hides_the_rates_beside_an_impact_on_a_block_that_moves(number: int) -> None:
    assert rated(made_elastic(scene_of(*STACK), number), **SWAYS) == [None]
    assert rated(made_elastic(scene_of(*STACK), number)) == [BY_PEAKS]


@pytest.mark.parametrize("other", [0.475, 0.53])
def test_two_impacts_at_once_have_no_rates_of_their_own(other: float) -> None:
    """Before or after: another one within the rows that are read; 0.3 s apart is far."""
    both = tuple(sorted((AT, other)))
    assert rated(scene_of(*STACK), impacts=both, **SWAYS) == [None, None]
    far = rated(scene_of(*STACK), impacts=(AT, 0.8), **SWAYS)
    assert far[0] == pytest.approx(0.7) and far[1] is not None


def test_an_impact_without_enough_rows_beside_it_has_no_rates() -> None:
    for at in (0.02, 0.97):
        assert rated(scene_of(*STACK), impacts=(at,), **SWAYS) == [None]


def slipping(since: float, until: float, by: float) -> dict[str, Array]:
    """Slip of the block between two times, m."""
    return {"block__slip_m": by * np.interp(T, [since, until], [0.0, 1.0])}


def test_where_a_block_slides_at_an_impact_on_ground_that_moves_its_rates_tell() -> None:
    """Within 0.4/p = 0.108 s; what it slips later is none of that impact's, nor is 1e-4 B/2."""
    assert rated(shaken(), **slipping(0.45, 0.55, 1e-3)) == pytest.approx([0.7])
    assert rated(shaken(), **slipping(0.7, 0.9, 1e-1)) == [BY_PEAKS]
    assert rated(shaken(), **slipping(0.1, 0.3, 1e-1)) == [BY_PEAKS]
    assert rated(shaken(), **slipping(0.45, 0.55, 2e-5)) == [BY_PEAKS]
    assert rated(shaken(), known=None, **slipping(0.45, 0.55, 1e-3)) == [None]
    assert rated(scene_of(""), **slipping(0.45, 0.55, 1e-3)) == [BY_PEAKS]


def test_an_elastic_block_that_skids_at_an_impact_keeps_what_was_read_of_it() -> None:
    """By 1e-3 of 0.4 m, as pivots do; by 1e-2 and more it slides, and nothing is known."""
    elastic = made_elastic(shaken(), 0)
    assert rated(elastic, **slipping(0.45, 0.55, 1e-3)) == [BY_PEAKS]
    assert rated(elastic, **slipping(0.45, 0.55, 1e-2)) == [None]


def falls(scene: Scene, places: list[tuple[float, float]], **columns: Any) -> list[bool]:
    """In which rows the last block falls, its middle at these places, m."""
    x, y = np.array(places).T
    name = scene.blocks[-1].name
    columns |= {f"{name}__centre_x_m": x, f"{name}__centre_y_m": y}
    history = history_of(scene, 0.1 * np.arange(len(places)), **columns)
    return [bool(row) for row in fallen(scene, history, scene.blocks[-1])]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_block_falls_where_nothing_of_the_top_is_under_it_or_all_of_it_is_below(
    side: float,
) -> None:
    """Upright, 0.4 x 1 m, on a block of that size, whose top is at 1 m and ends at 0.2 m."""
    rows = [
        ((0.0, 1.50), False),
        ((0.25, 1.49), False),  # its edge is still over the top
        ((0.41, 1.48), True),
        ((0.41, 1.60), False),  # on its way up
        ((0.45, 1.59), False),  # beside the top, but all of it above
        ((0.25, 0.90), False),  # its middle is below the top, its edge over it
        ((0.25, 0.49), True),
        ((0.10, 0.48), True),
    ]
    places = [(side * x, y) for (x, y), _ in rows]
    assert falls(scene_of(*STACK), places, low__centre_y_m=0.5) == [known for _, known in rows]


def test_a_foundation_that_drifts_carries_its_ends_with_it() -> None:
    """2 m wide: a block 0.4 m wide is beside it 1.2 m from its middle, wherever that is."""
    plate = {"kind": "elastic", "support": "rollers", "width": 2.0, "height": 0.1, "young": 2e11}
    plate |= {"poisson": 0.3, "mass_ratio": 2.0, "period": 0.5, "damping_ratio": 0.05}
    scene = parse_scene(scene_of("").to_dict() | {"foundation": plate})
    places = [(1.0, 0.5), (1.0, 0.49), (1.0, 0.48), (1.3, 0.47), (1.3, 0.46)]
    drift = np.array([0.0, 0.0, -0.25, -0.25, 0.2])
    assert falls(scene, places, platform__drift_m=drift) == [False, False, True, True, False]
