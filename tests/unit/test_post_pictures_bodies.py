"""Pictures of stacks, platforms and blocks in space, from made-up runs with files of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_up_runs import BLOCK, IN_SPACE, STACK, TIME, T, in_space, leave_run, stack
from numpy.typing import NDArray

from rockslip import parse_scene
from solver.fields.ground import floor_level

pytest.importorskip("matplotlib")
pytest.importorskip("pyvista")

Array = NDArray[np.float64]


def assert_pictures(folder: Path, names: list[str]) -> None:
    """These pictures, each with something on it."""
    from matplotlib.image import imread

    from rockslip import read_run
    from solver.pictures.pictures import picture_run

    files = picture_run(read_run(folder))
    assert [file.name for file in files] == names
    for file in files:
        pixels = imread(file)
        assert 0.02 < float(np.mean(np.any(pixels[:, :, :3] < 0.99, axis=2))) < 0.8


def test_pictures_of_a_stack_on_a_platform(tmp_path: Path) -> None:
    names = ["angle", "phase", "platform", "forces", "energy", "floors", "deformed"]
    assert_pictures(stack(tmp_path / "stack"), [f"{name}.png" for name in names])


def test_pictures_in_space(tmp_path: Path) -> None:
    names = ["angle", "phase", "forces", "energy", "deformed"]
    assert_pictures(in_space(tmp_path / "space"), [f"{name}.png" for name in names])


def test_what_curves_show(tmp_path: Path) -> None:
    """The numbers on the axes are those of the history, in the units of their labels."""
    from rockslip import read_run
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


def test_instants_are_those_of_the_block_that_rocks(tmp_path: Path) -> None:
    from rockslip import read_run
    from solver.pictures.instants import instants

    chosen = instants(read_run(stack(tmp_path / "stack")))
    first, impact, peak, last = (instant.time_s for instant in chosen)
    assert (first, last) == (0.0, 2.0)
    assert impact == pytest.approx(np.pi / 12, abs=1e-4)
    assert impact < peak < np.pi / 4


def test_bodies_stand_on_each_other(tmp_path: Path) -> None:
    """Outlines of all parts; the view in space keeps heights and hides what is behind."""
    from solver.pictures.deformed import ABOVE, read_snapshots

    (plane,) = read_snapshots(stack(tmp_path / "stack") / "fields.pvd", [0.0])
    assert len(plane.outlines) == 3
    # the floor is below the platform; the upper block leans by 0.1 on the top of the lower one
    assert plane.low[1] == floor_level(parse_scene(STACK)) < 0
    assert plane.outlines[0][:, 1].min() == pytest.approx(0.0, abs=1e-12)
    assert plane.outlines[1][:, 1].min() == pytest.approx(
        1.5 + 0.015 - 0.5 * np.cos(0.1) - 0.15 * np.sin(0.1)
    )
    (space,) = read_snapshots(in_space(tmp_path / "space") / "fields.pvd", [0.0], dimension=3)
    assert len(space.outlines) == 6
    assert [outline.shape for outline in space.outlines] == [(4, 2)] * 6
    # the front face is drawn last but for the top and the side: three faces are seen
    areas = [_area(outline) for outline in space.outlines]
    assert sum(area > 0 for area in areas) == 3
    assert all(area > 0 for area in areas[3:])
    assert sum(areas) == pytest.approx(0.0, abs=1e-12)
    assert 0 < ABOVE < np.pi / 2


def test_lift_off_largest_angle_and_landing(tmp_path: Path) -> None:
    """One swing from 0.5 to 1.0 s; a block that overturns is shown until it lies."""
    from rockslip import read_run
    from solver.pictures.instants import instants

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
    from rockslip import read_run
    from solver.pictures.angles import draw_angle
    from solver.pictures.forces import draw_forces

    lean = np.where((T > 0.5) & (T < 1), 0.1 * np.sin((T - 0.5) / 0.5 * np.pi), 0.0)
    values = {"block.angle_rad": lean, "block.angle_y_rad": lean}
    run = read_run(leave_run(tmp_path / "a", parse_scene(IN_SPACE), values))
    for figure in (draw_angle(run, None), draw_forces(run)):
        np.testing.assert_allclose(figure.axes[-1].get_xlim(), (0.475, 1.025), atol=0.01)


def test_the_ground_stands_above_the_angle(tmp_path: Path) -> None:
    from rockslip import read_run
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
    from rockslip import read_run
    from solver.pictures.energy import draw_energy

    lean = np.clip(T - 1.0, 0, 1) * np.pi / 2
    drop = np.where(T > 1.6, -300.0 * (T - 1.6), 5 * np.sin(6 * T))
    values = {"block.angle_y_rad": lean, "energy.gravity_J": drop, "energy.total_J": drop}
    run = read_run(leave_run(tmp_path / "a", parse_scene(IN_SPACE), values))
    above = draw_energy(run).axes[0]
    assert "fall cut off" in above.get_ylabel()
    low, high = above.get_ylim()
    assert high - low < 30


def test_nothing_is_drawn_below_the_floor(tmp_path: Path) -> None:
    """A block that has sunk has no face in space whose points are all below."""
    from solver.pictures.deformed import read_snapshots

    folder = in_space(tmp_path / "space")
    (above,) = read_snapshots(folder / "fields.pvd", [0.0], dimension=3, floor=0.0)
    assert len(above.outlines) == 6
    (cut,) = read_snapshots(folder / "fields.pvd", [0.0], dimension=3, floor=0.5)
    assert len(cut.outlines) == 5
    assert len(cut.von_mises) == 5


def test_a_record_has_its_husid_plot_and_spectrum(tmp_path: Path) -> None:
    """Those of a sine: half of the intensity in half of the time, resonance at its period."""
    from rockslip import read_run
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


def _area(outline: Array) -> float:
    """Signed area of a polygon."""
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_copies_of_cells_are_left_out_of_surfaces(tmp_path: Path) -> None:
    """Of two cubes, one the copy of another rank's, the surface of the other is read."""
    import pyvista

    from solver.pictures.surfaces import FieldFiles

    x, y, z = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], [0.0, 1.0], indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    cubes = [[8, *(4 * k + np.array([0, 4, 6, 2, 1, 5, 7, 3]))] for k in (0, 1)]
    grid = pyvista.UnstructuredGrid(np.concatenate(cubes), [12, 12], places)
    grid.point_data["displacement"] = np.tile([0.5, 0.0, 0.0], (12, 1))
    grid.cell_data["von_mises"] = [3.0, 7.0]
    grid.cell_data["vtkGhostType"] = np.array([1, 0], dtype=np.uint8)
    grid.save(tmp_path / "body.vtu")
    (tmp_path / "fields.pvd").write_text(
        '<VTKFile type="Collection"><Collection>'
        '<DataSet timestep="0" part="0" name="block" file="body.vtu"/></Collection></VTKFile>'
    )
    (surface,) = FieldFiles(tmp_path / "fields.pvd", 3).read(0)
    assert surface.n_cells == 6
    assert surface.area == pytest.approx(6.0)
    assert list(surface.cell_data["von_mises"]) == [7.0] * 6
    assert surface.bounds[:2] == pytest.approx((1.5, 2.5))
