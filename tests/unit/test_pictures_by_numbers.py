"""What the pictures and the page of a run show, from made-up histories: curves, units, labels."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from html_page import Page
from made_up_runs import BLOCK, IN_SPACE, STACK, TIME, T, leave_run

from rockslip import History, Scene, parse_scene, read_run
from solver.excitation.spectrum import PERIODS
from solver.history.history import scene_columns
from solver.results.runs import Run
from solver.types import Array

pytest.importorskip("matplotlib")
pytest.importorskip("pyvista")

SINE = "[motion]\nkind = 'sine'\namplitude_g = 0.1\nperiod = 1\n"


def without_rows(scene: Scene, summary: dict[str, Any]) -> Run:
    """A run of which only scene and summary count."""
    return Run(folder=Path(), scene=scene, history=History(scene_columns(scene)), summary=summary)


def curves_of(axes: Any) -> dict[str, Array]:
    """What the curves of a panel show, by their labels."""
    return {line.get_label(): np.asarray(line.get_ydata()) for line in axes.lines}


def test_lost_energies_have_the_names_of_their_causes(tmp_path: Path) -> None:
    """All of them from zero on, whatever the energy at the start; the ground does work, too."""
    from solver.pictures.energy import draw_energy

    rates = {"damping": 1.0, "contact_damping": 2.0, "friction": 4.0, "contact": 8.0,
             "numerical": 16.0}  # fmt: skip
    names = {"damping": "damping", "contact_damping": "contact dashpots", "friction": "friction",
             "contact": "contact", "numerical": "time integration"}  # fmt: skip
    values = {f"energy.{name}_J": rate * T for name, rate in rates.items()}
    values |= {"energy.input_J": 6 * T, "energy.total_J": 1000.0 + (6 - 31) * T}
    run = read_run(leave_run(tmp_path / "run", parse_scene(IN_SPACE), values))
    _, below = draw_energy(run).axes
    curves = curves_of(below)
    for cause, label in names.items():
        np.testing.assert_allclose(curves[label], rates[cause] * T, err_msg=label)
    np.testing.assert_allclose(curves["energy lost"], 31 * T, atol=1e-9)
    np.testing.assert_allclose(curves["sum of the causes"], 31 * T)
    np.testing.assert_allclose(curves["work of the ground"], 6 * T)


def test_the_acceleration_of_a_platform_is_that_of_the_ground_and_its_own(tmp_path: Path) -> None:
    from solver.pictures.forces import draw_platform

    values = {
        "base.acceleration_m_s2": 0.981 * np.sin(2 * np.pi * T),
        "platform.acceleration_m_s2": -2.943 * np.cos(5 * T),
    }
    run = read_run(leave_run(tmp_path / "run", parse_scene(STACK + SINE), values))
    below = draw_platform(run, None).axes[2]
    assert below.get_ylabel() == "acceleration (g)"
    ground, platform = (np.asarray(line.get_ydata()) for line in below.lines[:2])
    np.testing.assert_allclose(ground, 0.1 * np.sin(2 * np.pi * T), atol=1e-12)
    both = 0.1 * np.sin(2 * np.pi * T) - 0.3 * np.cos(5 * T)
    np.testing.assert_allclose(platform, both, atol=1e-12)


def test_spectra_of_floors_are_in_g() -> None:
    from solver.pictures.floors import draw_floors

    spectra = {"ground": 9.81 * np.ones(len(PERIODS)), "floor 1": 19.62 / PERIODS}
    (axes,) = draw_floors(spectra).axes
    assert axes.get_ylabel().startswith("PSA (g)")
    curves = curves_of(axes)
    np.testing.assert_allclose(curves["ground"], 1.0)
    np.testing.assert_allclose(curves["floor 1"], 2 / PERIODS)


@pytest.mark.parametrize(
    ("stress", "shown", "unit"),
    [(5e4, 50.0, "kPa"), (9.9e4, 99.0, "kPa"), (1.5e5, 0.15, "MPa"), (2.5e6, 2.5, "MPa")],
)
def test_stresses_have_their_unit(stress: float, shown: float, unit: str) -> None:
    """On the bar beside the bodies, and above a film."""
    from solver.pictures.deformed import Snapshot, draw_snapshots
    from solver.pictures.film.strip import _add_legend
    from solver.pictures.instants import Instant
    from solver.pictures.style import new_figure

    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    snapshot = Snapshot(
        time_s=0.0, outlines=[square, square + np.array([0.0, 1.0])], von_mises=np.full(2, stress),
        least=np.zeros(3), most=np.array([1.0, 2.0, 0.0]),
    )  # fmt: skip
    figure = new_figure(3.0)
    draw_snapshots(figure, [snapshot], [Instant(0.0, "")], dimension=2, floor=0.0)
    bodies, bar = figure.axes
    (cells,) = bodies.collections
    np.testing.assert_allclose(cells.get_array(), shown)
    assert cells.get_clim() == pytest.approx((0.0, shown))
    assert bar.get_ylabel() == f"von Mises stress ({unit})"
    heading = new_figure(0.62)
    heading.set_layout_engine("none")
    _add_legend(heading, stress)
    assert [text.get_text() for text in heading.texts] == ["0", f"{shown:g} {unit} von Mises"]


@pytest.mark.parametrize(
    ("dimension", "directions"),
    [(2, ("along x", "vertical")), (3, ("along x", "along y", "vertical"))],
)
def test_motions_of_the_ground_are_named_by_their_directions(
    tmp_path: Path, dimension: int, directions: tuple[str, ...]
) -> None:
    from solver.pictures.ground import sampled_motions

    peaks = {"along x": 1.0, "along y": 2.0, "vertical": 3.0}
    keys = {"along x": "motion", "along y": "motion.second", "vertical": "motion.vertical"}
    text = f"dimension = {dimension}\n{BLOCK}width = 0.4\n{TIME}"
    for name in directions:
        file = tmp_path / f"{name.replace(' ', '_')}.txt"
        file.write_text(f"0 0\n0.1 {peaks[name]}\n0.2 -0.5\n0.3 0\n")
        text += f"[{keys[name]}]\nkind = 'record'\nfile = '{file}'\nunits = 'm/s2'\n"
    found = sampled_motions(without_rows(parse_scene(text), {}))
    assert {name: part.value.max() for name, _, part in found} == {
        name: pytest.approx(peaks[name]) for name in directions
    }


def test_forces_of_a_film_are_means_of_what_each_step_ends_with() -> None:
    """A row tells the mean of the step before it; frames end within steps."""
    from solver.pictures.film.contact import _means

    time, values = np.array([0.0, 0.1, 0.3, 0.4]), np.array([9.0, 1.0, 2.0, 4.0])
    found = _means(time, values, np.array([0.0, 0.2, 0.4]))
    assert found == pytest.approx([1.0, (0.1 * 1 + 0.1 * 2) / 0.2, (0.1 * 2 + 0.1 * 4) / 0.2])


def test_the_page_tells_forces_in_kilonewtons_and_means_of_what_is_known() -> None:
    """One of three restitutions is not known."""
    from solver.pictures.page.run_page import _blocks, _platform

    page = Page()
    page.feed(
        "".join(
            _platform(
                {
                    "platform": {
                        "peak_drift_m": 0.0123,
                        "residual_drift_m": -0.0045,
                        "peak_base_shear_N": 12500.0,
                        "peak_overturning_moment_Nm": 880.0,
                    }
                }
            )
        )
    )
    told = page.text.replace("\n", "")
    for words in (
        *("peak drift of the platform (mm)12.3", "residual drift (mm)-4.5"),
        *("peak base shear (kN)12.5", "peak overturning moment (kN m)0.88"),
    ):
        assert words in told
    entry = {
        "impacts": [{"restitution": 0.9}, {"restitution": None}, {"restitution": 0.8}],
        "peak_angle_rad": np.radians(3.0),
        "peak_angle_over_alpha": 0.25,
        "peak_slip_m": 0.012,
        "residual_slip_m": -0.0034,
        "peak_displacement_m": 0.15,
        "peak_turn_rad": np.radians(2.0),
        "mode": "rock",
        "fell_at_s": 1.5,
    }
    run = SimpleNamespace(
        scene=parse_scene(f"{BLOCK}width = 0.4\n{TIME}"), summary={"blocks": {"block": entry}}
    )
    _, row = _blocks(cast(Run, run))
    assert row == ["block", "3", "0.25", "12", "-3.4", "150", "2", "3", "0.85", "rock at 1.5 s"]
    entry["impacts"] = [{"restitution": None, "reason": "it hops"}] * 2
    _, row = _blocks(cast(Run, run))
    assert row[7:9] == ["2", "none: it hops"]
