"""Content of the pictures and the page of a run, from made-up histories: curves, units, bodies."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from made_up_runs import BLOCK, IN_SPACE, STACK, TIME, T, in_space, leave_run, stack

from rockslip import History, Scene, parse_scene, read_run
from solver.cli import main
from solver.excitation.spectrum import PERIODS
from solver.fields.ground import floor_level
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
    """Ordinates of the curves of a panel, by their labels."""
    return {line.get_label(): np.asarray(line.get_ydata()) for line in axes.lines}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "names"),
    [
        (stack, ["angle", "phase", "platform", "forces", "energy", "floors", "deformed"]),
        (in_space, ["angle", "phase", "forces", "energy", "deformed"]),
    ],
)
def test_pictures_of_a_run(make: Any, names: list[str], tmp_path: Path) -> None:
    """Each has something on it; no display is needed."""
    from matplotlib.image import imread

    from solver.pictures.pictures import picture_run

    files = picture_run(read_run(make(tmp_path / "run")))
    assert [file.name for file in files] == [f"{name}.png" for name in names]
    for file in files:
        pixels = imread(file)
        assert 0.02 < float(np.mean(np.any(pixels[:, :, :3] < 0.99, axis=2))) < 0.8


def test_bodies_in_space_need_vtk_that_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line says so, and all other pictures are there."""
    from solver.errors import EnvironmentTrouble
    from solver.pictures import deformed

    def none() -> Any:
        raise EnvironmentTrouble("no display")

    monkeypatch.setattr(deformed, "display", none)
    folder = in_space(tmp_path / "run")
    assert main(["plot", str(folder)]) == 0
    said = capsys.readouterr()
    assert said.err == "the bodies in space are not drawn: no display\n"
    assert len(said.out.splitlines()) == 5


@pytest.mark.slow
def test_pictures_for_papers(tmp_path: Path) -> None:
    """As PDF and SVG, which are what their names say; a new run takes them away."""
    (tmp_path / "scene.toml").write_text(
        f"{BLOCK}width = 0.25\ntilt_deg = 3.0\n[time]\nend = 0.6\nstep = 0.002\n"
    )
    command = ["reference", str(tmp_path / "scene.toml"), "-q", "-o"]
    assert main([*command, str(tmp_path / "one")]) == 0
    assert main(["plot", str(tmp_path / "one"), "--format", "pdf", "svg"]) == 0
    for name in ("angle", "forces", "phase"):
        assert (tmp_path / "one" / f"{name}.pdf").read_bytes().startswith(b"%PDF")
        assert "<svg" in (tmp_path / "one" / f"{name}.svg").read_text()
    assert {file.suffix for file in (tmp_path / "one").iterdir()} & {".png", ".vtu"} == set()
    assert main([*command, str(tmp_path / "one"), "--force"]) == 0
    assert {file.suffix for file in (tmp_path / "one").iterdir()} == {".csv", ".json", ".toml"}
    # the start, the first impact (Housner: 0.1916 s), the peak after it, the end
    from solver.pictures.deformed import instants

    chosen = instants(read_run(tmp_path / "one"))
    assert [instant.name for instant in chosen] == ["release", "landing", "next peak", "end"]
    times = [instant.time_s for instant in chosen]
    assert times == pytest.approx([0.0, 0.1916, (0.1916 + 0.5305) / 2, 0.6], abs=1e-3)
    # two runs over each other
    assert main([*command, str(tmp_path / "two"), "--set", "block.tilt_deg=-2.0"]) == 0
    assert main(["plot", *(str(tmp_path / n) for n in ("one", "two")), "-o", str(tmp_path)]) == 0
    assert (tmp_path / "overlay.png").is_file()


def test_what_curves_show(tmp_path: Path) -> None:
    """The numbers on the axes are those of the history, in the units of their labels."""
    from solver.pictures.angles import draw_angle, draw_overlay
    from solver.pictures.energy import draw_energy
    from solver.pictures.forces import draw_forces, draw_platform

    run = read_run(stack(tmp_path / "stack"))
    (angles,) = draw_angle(run, None).axes[:1]
    curves = {line.get_label(): line.get_ydata() for line in angles.lines}
    np.testing.assert_allclose(curves["upper"], np.degrees(run.history["upper.angle_rad"]))
    drift, _, acceleration = draw_platform(run, None).axes
    np.testing.assert_allclose(drift.lines[0].get_ydata(), 50 * np.sin(8 * T))
    np.testing.assert_allclose(acceleration.lines[1].get_ydata(), -3.2 / 9.81 * np.sin(8 * T))
    # standing is 1 on both: the lower block carries twice its weight
    low, up, slips = draw_forces(run).axes
    assert np.median(low.lines[0].get_ydata()) == pytest.approx(1)
    assert np.median(up.lines[0].get_ydata()) == pytest.approx(1)
    assert low.get_ylim()[1] < 5
    np.testing.assert_allclose(slips.lines[0].get_ydata(), 20 * (1 - np.cos(3 * T)))
    stored = draw_energy(run).axes[0]
    curves = {line.get_label(): line.get_ydata() for line in stored.lines}
    raised = 981 * 0.15 * np.abs(run.history["upper.angle_rad"])
    np.testing.assert_allclose(curves["gravity above upright"], raised, atol=1e-9)
    # a run without a platform beside it: three panels, the third with one curve
    other = read_run(in_space(tmp_path / "space"))
    panels = draw_overlay([run, other]).axes
    assert [len(axes.lines) for axes in panels] == [3, 3, 2]


def test_lift_off_largest_angle_and_landing(tmp_path: Path) -> None:
    """One swing from 0.5 to 1.0 s; a block that overturns is shown until it lies."""
    from solver.pictures.deformed import instants

    scene = parse_scene(IN_SPACE)
    lean = np.where((T > 0.5) & (T < 1), 0.1 * np.sin((T - 0.5) / 0.5 * np.pi), 0.0)
    run = read_run(leave_run(tmp_path / "a", scene, {"block.angle_y_rad": lean}))
    chosen = instants(run)
    assert [i.name for i in chosen] == ["lift-off", "largest angle", "landing", "at rest"]
    times = [i.time_s for i in chosen]
    np.testing.assert_allclose(times, [0.5, 0.75, 1.0, 1.025], atol=6e-3)
    lean = np.clip(T - 0.5, 0, 1) * np.pi / 2
    run = read_run(leave_run(tmp_path / "b", scene, {"block.angle_y_rad": lean}))
    chosen = instants(run)
    assert [i.name for i in chosen] == ["lift-off", "falling", "overturned", "end"]
    # beyond 2 alpha, 43.6 degrees
    assert chosen[2].time_s == pytest.approx(0.5 + 2 * np.arctan(0.4) / (np.pi / 2), abs=3e-3)


def test_time_axes_end_where_nothing_moves(tmp_path: Path) -> None:
    from solver.pictures.angles import draw_angle
    from solver.pictures.forces import draw_forces

    lean = np.where((T > 0.5) & (T < 1), 0.1 * np.sin((T - 0.5) / 0.5 * np.pi), 0.0)
    values = {"block.angle_rad": lean, "block.angle_y_rad": lean}
    run = read_run(leave_run(tmp_path / "a", parse_scene(IN_SPACE), values))
    for figure in (draw_angle(run, None), draw_forces(run)):
        np.testing.assert_allclose(figure.axes[-1].get_xlim(), (0.475, 1.025), atol=0.01)


def test_the_ground_stands_above_the_angle(tmp_path: Path) -> None:
    from solver.pictures.angles import draw_angle

    scene = parse_scene(IN_SPACE + "[motion]\nkind = 'sine'\namplitude_g = 0.1\nperiod = 1\n")
    shaking = 0.981 * np.sin(2 * np.pi * T)
    run = read_run(leave_run(tmp_path / "a", scene, {"base.acceleration_m_s2": shaking}))
    ground, angle = draw_angle(run, None).axes[:2]
    np.testing.assert_allclose(ground.lines[0].get_ydata(), shaking / 9.81)
    assert ground.get_position().y0 > angle.get_position().y0
    assert ground.get_xlim() == angle.get_xlim()


def test_the_fall_does_not_dwarf_the_energies(tmp_path: Path) -> None:
    """The axes show what was there while the block stood."""
    from solver.pictures.energy import draw_energy

    lean = np.clip(T - 1.0, 0, 1) * np.pi / 2
    drop = np.where(T > 1.6, -300.0 * (T - 1.6), 5 * np.sin(6 * T))
    values = {"block.angle_y_rad": lean, "energy.gravity_J": drop, "energy.total_J": drop}
    run = read_run(leave_run(tmp_path / "a", parse_scene(IN_SPACE), values))
    above = draw_energy(run).axes[0]
    assert "fall cut off" in above.get_ylabel()
    low, high = above.get_ylim()
    assert high - low < 30


def test_bodies_stand_on_each_other(tmp_path: Path) -> None:
    """In the plane: the floor is below the platform, the upper block leans on the lower one."""
    from solver.pictures.deformed import Instant, snapshots_of

    (plane,) = snapshots_of(read_run(stack(tmp_path / "stack")), [Instant(0.0)])
    lower, upper, platform = plane.surfaces
    assert platform.bounds[2] == floor_level(parse_scene(STACK)) < 0
    assert lower.bounds[2] == pytest.approx(0.0, abs=1e-12)
    lean = 1.5 + 0.015 - 0.5 * np.cos(0.1) - 0.15 * np.sin(0.1)
    assert upper.bounds[2] == pytest.approx(lean)
    # in space what has sunk below the floor is cut off
    run = read_run(in_space(tmp_path / "space"))
    found = []
    for level in (-1.0, 0.5):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("solver.pictures.deformed.floor_level", lambda scene, level=level: level)
            found += snapshots_of(run, [Instant(0.0)])
    whole, cut = found
    assert whole.surfaces[0].area == pytest.approx(2 * 0.4 * 0.3 + 1.4)
    assert cut.surfaces[0].bounds[4] == pytest.approx(0.5)


def test_what_is_nearer_hides_what_is_behind() -> None:
    """A wide lid on a column, and a plate behind both: colours at places of the picture."""
    import pyvista

    from solver.pictures.renderer import Renderer, display, in_view

    low, high = np.array([-1.0, -1.0, 0.0]), np.array([1.0, 1.0, 1.5])
    column = pyvista.Box((-0.2, 0.2, -0.2, 0.2, 0.0, 1.0)), "#ff0000"
    lid = pyvista.Box((-0.6, 0.6, -0.6, 0.6, 1.0, 1.2)), "#00ff00"
    plate = pyvista.Box((-0.9, 0.9, 0.8, 0.9, 0.0, 1.2)), "#0000ff"
    window = np.array([-1.5, -1.0]), np.array([1.5, 2.0])
    with display():
        look = {"window": window, "floor": 0.0, "limit": 0.0, "beyond": 0.5}
        renderer = Renderer((300, 300), low, high, **look)
        drawn = renderer.draw([lid, plate, column])
        renderer.close()
    for place, channel in (
        ((0.0, -0.2, 0.5), 0),  # before the plate
        ((0.0, 0.0, 1.2), 1),  # the top of the lid
        ((0.4, -0.6, 1.1), 1),  # its front, before the plate
        ((-0.75, 0.8, 0.4), 2),  # beside both
    ):
        x, y = in_view(np.array([place]))[0]
        pixel = drawn[round(300 * (2.0 - y) / 3.0), round(300 * (x + 1.5) / 3.0)].astype(int)
        assert pixel.argmax() == channel and np.ptp(pixel) > 100, (place, pixel)


@pytest.mark.slow
def test_a_record_has_its_husid_plot_and_spectrum(tmp_path: Path) -> None:
    """Those of a sine: half of the intensity in half of the time, resonance at its period."""
    from solver.pictures.ground import draw_motion, sampled_motions
    from solver.pictures.pictures import picture_run

    record = tmp_path / "record.txt"
    time = np.arange(2001) * 0.005
    samples = 0.2 * np.sin(2 * np.pi * time / 0.5)
    record.write_text("".join(f"{t:.3f} {a:.6f}\n" for t, a in zip(time, samples, strict=True)))
    scene = parse_scene(
        IN_SPACE + f"[motion]\nkind = 'record'\nfile = '{record}'\nunits = 'g'\nstart = 2\n"
    )
    run = read_run(leave_run(tmp_path / "a", scene, {}))
    figure = draw_motion(sampled_motions(run))
    accelerogram, husid, spectrum = (figure.axes[k] for k in (0, 2, 1))
    assert np.abs(accelerogram.lines[0].get_ydata()).max() == pytest.approx(0.2, rel=1e-3)
    assert accelerogram.lines[0].get_xdata()[[0, -1]] == pytest.approx([2.0, 12.0])
    grown = husid.lines[0]
    assert np.interp(7.0, grown.get_xdata(), grown.get_ydata()) == pytest.approx(50, abs=0.5)
    periods, psa = spectrum.lines[0].get_xdata(), spectrum.lines[0].get_ydata()
    assert periods[np.argmax(psa)] == pytest.approx(0.5, rel=0.05)
    # steady state of the resonance, 1/(2 xi) times the ground; periods are 3.5 % apart
    assert psa.max() == pytest.approx(0.2 / 0.1, rel=0.06)
    assert "motion.png" in [file.name for file in picture_run(run)]
    record.unlink()
    assert sampled_motions(run) == []


@pytest.mark.parametrize(
    ("foundation", "level"),
    [
        ("kind = 'rigid'", 0.0),
        ("kind = 'elastic'\nwidth = 2\nheight = 0.2\ndensity = 1", -0.2),
        (
            "kind = 'frame'\ndeck = { width = 2, height = 0.2 }\ncolumn = { width = 0.1 }\n"
            "storey = 1.5\ndensity = 1",
            -1.7,
        ),
    ],
)
def test_floor_level(foundation: str, level: float) -> None:
    """At the feet of whatever carries the blocks."""
    meshed = "" if "rigid" in foundation else "young = 1e9\npoisson = 0.2\n"
    scene = parse_scene(f"{BLOCK}width = 0.5\n[foundation]\n{foundation}\n{meshed}{TIME}")
    assert floor_level(scene) == pytest.approx(level)


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
    from solver.pictures.ground import draw_floors

    spectra = {"ground": 9.81 * np.ones(len(PERIODS)), "floor 1": 19.62 / PERIODS}
    (axes,) = draw_floors(spectra).axes
    assert axes.get_ylabel().startswith("PSA (g)")
    curves = curves_of(axes)
    np.testing.assert_allclose(curves["ground"], 1.0)
    np.testing.assert_allclose(curves["floor 1"], 2 / PERIODS)


@pytest.mark.parametrize(
    ("stress", "shown", "unit"),
    [(9.9e4, 99.0, "kPa"), (1.5e5, 0.15, "MPa")],
)
def test_stresses_have_their_unit(stress: float, shown: float, unit: str) -> None:
    """On the bar beside the bodies, and above a film."""
    import pyvista

    from solver.pictures.deformed import Instant, Snapshot, draw_snapshots
    from solver.pictures.film import _add_legend
    from solver.pictures.style import new_figure

    square = pyvista.Plane(i_resolution=1, j_resolution=2)
    square.cell_data["von_mises"] = np.full(2, stress)
    figure = new_figure(3.0)
    scene = parse_scene(f"{BLOCK}width = 0.4\n{TIME}")
    draw_snapshots(figure, [Snapshot(instant=Instant(0.0), surfaces=[square])], scene)
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
    from solver.pictures.contact import _means

    time, values = np.array([0.0, 0.1, 0.3, 0.4]), np.array([9.0, 1.0, 2.0, 4.0])
    found = _means(time, values, np.array([0.0, 0.2, 0.4]))
    assert found == pytest.approx([1.0, (0.1 * 1 + 0.1 * 2) / 0.2, (0.1 * 2 + 0.1 * 4) / 0.2])


def test_the_page_tells_means_of_what_is_known() -> None:
    """One of three restitutions is not known."""
    from solver.pictures.page import _blocks

    entry = {
        "impacts": [{"restitution": 0.9}, {"restitution": None}, {"restitution": 0.8}],
        "peak_angle_rad": np.radians(3.0),
        "peak_angle_over_alpha": 0.25,
        "peak_slip_m": 0.012,
        "residual_slip_m": -0.0034,
        "peak_displacement_m": 0.15,
        "peak_turn_rad": np.radians(2.0),
        "mode": "rock",
        "overturned_at_s": None,
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
