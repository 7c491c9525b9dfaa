"""Words for what a block did, from made-up histories, each mode by its own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from histories import history_of, scene_of, summary_of

from rockslip import History, Scene
from solver.results.report import report

WIDTH, HEIGHT, THICKNESS = 0.4, 1.0, 0.3
ALPHA = math.atan(WIDTH / HEIGHT)
T = np.linspace(0, 1, 201)
WEIGHT = 981.0


def told(dimension: int = 2, **columns: Any) -> dict[str, Any]:
    """The summary's entries of a block with such columns, which presses on the ground."""
    scene = scene_of("", dimension=dimension)
    return summary_of(scene, made(scene, **columns))["blocks"]["block"]


def made(scene: Scene, **columns: Any) -> History:
    """A history of a block that stands with its weight unless it says otherwise."""
    up = f"centre_{'xyz'[scene.dimension - 1]}_m"
    own = {up: HEIGHT / 2, "normal_force_N": WEIGHT} | columns
    return history_of(scene, T, **{f"block__{name}": value for name, value in own.items()})


def rocking(angle: Any) -> dict[str, Any]:
    """Columns of a block that leans by an angle (rad) on its corners."""
    lift = WIDTH * np.sin(np.abs(angle))
    return {"angle_rad": angle, "gap_left_m": np.where(angle > 0, lift, 0.0),
            "gap_right_m": np.where(angle < 0, lift, 0.0)}  # fmt: skip


def flight(first: float, last: float, height: float) -> dict[str, Any]:
    """Columns of a block whose corners fly over a parabola between two times."""
    part = np.clip((T - first) / (last - first), 0, 1)
    gap = 4 * height * part * (1 - part)
    force = np.where((gap > 0), 0.0, WEIGHT)
    return {"gap_left_m": gap, "gap_right_m": gap, "normal_force_N": force}


SWING = 0.03 * np.cos(2 * math.pi * T)
BOLD = 1.2 * ALPHA * np.sin(math.pi * T)


@pytest.mark.parametrize(
    ("mode", "columns"),
    [
        ("rest", {}),
        ("slide", {"slip_m": 0.01 * T}),
        ("rest", {"slip_m": 0.003 * T}),
        ("rock", rocking(SWING)),
        ("slide-rock", rocking(SWING) | {"slip_m": 0.01 * T}),
        # A soft block that bends with both corners on the ground does not rock.
        ("rest", {"angle_rad": SWING}),
        ("hop", flight(0.2, 0.4, 0.02)),
        # The steps of a hop are not slip; an elastic block that vibrates does not hop.
        ("hop", flight(0.2, 0.4, 0.02) | {"slip_m": np.clip(T - 0.2, 0, 0.2)}),
        ("rest", flight(0.2, 0.21, 4e-4)),
        ("hop", flight(0.2, 0.25, 3e-3) | {"slip_m": np.clip(T - 0.2, 0, 0.05)}),
        ("slide-hop", flight(0.2, 0.4, 0.02) | {"slip_m": 0.05 * T}),
        # Beyond the point of balance and back; tipping over; a turn that ends upright.
        ("rock", rocking(BOLD)),
        ("overturned", rocking(math.pi / 2 * T)),
        ("overturned", rocking(np.minimum(20 * T, 2 * math.pi))),
        ("overturned", rocking(1.1 * ALPHA * T)),
        ("fell", {"slip_m": 0.01 * T, "centre_y_m": 0.5 - T}),
    ],
)
def test_modes(mode: str, columns: dict[str, Any]) -> None:
    assert told(**columns)["mode"] == mode


def test_a_block_on_one_that_falls_over_is_overturned() -> None:
    """Although it stays on it."""
    scene = scene_of("name = 'low'", "name = 'up'\non = 'low'")
    angle = 1.4 * T
    place = {"centre_x_m": np.sin(angle), "centre_y_m": 0.5 + np.cos(angle), "angle_rad": angle}
    up = {f"up__{name}": value for name, value in place.items()}
    history = history_of(scene, T, low__angle_rad=angle, low__centre_y_m=0.5, **up)
    assert summary_of(scene, history)["blocks"]["up"]["mode"] == "overturned"


def test_a_turn_about_the_vertical_is_told() -> None:
    """In 3-D by its corners: half the diagonal of the base, 0.25 m, times the turn."""
    beside = {"angle_z_rad": 0.43 * T}
    block = told(3, **beside)
    assert (block["mode"], block["peak_slip_m"]) == ("turn", 0.0)
    assert block["peak_turn_rad"] == block["residual_turn_rad"] == pytest.approx(0.43)
    assert told(3, angle_z_rad=0.0155 * T)["mode"] == "rest"
    assert told(3, angle_z_rad=-0.0165 * T)["mode"] == "turn"
    assert told(3, **beside, slip_second_m=-0.02 * T)["mode"] == "slide-turn"
    assert "peak_turn_rad" not in told()


def test_turns_of_more_than_a_half_are_counted_on() -> None:
    """A rotation vector begins anew at half a turn; a lean about a level axis is no turn."""
    turn = 10.0 * T
    block = told(3, angle_z_rad=np.angle(np.exp(1j * turn)))
    assert block["residual_turn_rad"] == pytest.approx(10.0)
    assert told(3, angle_x_rad=0.05 * T, angle_y_rad=0.05 * T)["peak_turn_rad"] < 1e-12


def test_a_block_does_not_turn_on_one_that_turns_with_it() -> None:
    scene = scene_of("name = 'low'", "name = 'up'\non = 'low'", dimension=3)
    both = {f"{name}__angle_z_rad": 0.4 * T for name in ("low", "up")}
    history = history_of(scene, T, **both, low__centre_z_m=0.5, up__centre_z_m=1.5)
    blocks = summary_of(scene, history)["blocks"]
    assert [blocks[name]["mode"] for name in ("low", "up")] == ["turn", "rest"]


def test_slip_is_in_contact_and_displacement_is_all_of_it() -> None:
    """It flies 0.3 m, in the row of its landing, too, then slides back by 0.1 m."""
    way = np.interp(T, [0.2, 0.4, 0.9], [0.0, 0.3, 0.2])
    block = told(**flight(0.2, 0.4, 0.05), slip_m=way)
    assert block["mode"] == "slide-hop"
    assert block["peak_slip_m"] == pytest.approx(0.1, abs=1e-12)
    assert block["residual_slip_m"] == pytest.approx(-0.1, abs=1e-12)
    assert block["peak_displacement_m"] == pytest.approx(0.3)
    assert block["residual_displacement_m"] == pytest.approx(0.2)


def test_the_report_tells_turns_and_flights() -> None:
    def line(dimension: int, **columns: Any) -> str:
        scene = scene_of("", dimension=dimension)
        return report(summary_of(scene, made(scene, **columns))).splitlines()[1]

    assert line(3, angle_z_rad=0.43 * T).endswith(", turned by 24.64 degrees about the vertical")
    flown = line(2, **flight(0.2, 0.4, 0.05), slip_m=np.clip(T - 0.2, 0, 0.2))
    assert flown.endswith("residual slip 0 mm, displacement 200 mm with what it flew")
    assert line(2, slip_m=0.01 * T).endswith("peak slip 10 mm, residual slip 10 mm")
