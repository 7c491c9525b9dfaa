"""Runs of shapes: their pictures, films, fields, force arrows and what is said of them."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rockslip import load_scene, parse_scene, read_run, simulate
from solver.cli import main
from solver.errors import SceneError
from solver.history.history import scene_columns
from solver.results.motion import boxes, slenderness
from solver.results.overlaps import overlaps
from solver.results.runs import Run
from solver.run.describe import describe

pytest.importorskip("matplotlib")
pytest.importorskip("pyvista")
pytest.importorskip("PIL")

ROOT = Path(__file__).parents[2]

MUSEUM = ROOT / "demos" / "museum"

L = "shape = { polygon = [[0, 0], [0.8, 0], [0.8, 0.3], [0.3, 0.3], [0.3, 1.2], [0, 1.2]] }"

SHAPES = {
    "plane": (2, f"{L}\nthickness = 0.4"),
    "prism": (3, f"{L}\nthickness = 0.4"),
    "bottle": (3, "shape = { profile = [[0, 0], [0.2, 0], [0.2, 0.5], [0.1, 1.0], [0, 1.0]] }"),
    "vase": (
        3,
        "shape = { profile = [[0, 0], [0.2, 0], [0.25, 0.4], [0.1, 0.7], [0.14, 0.9], [0.12, 0.9],"
        " [0.08, 0.7], [0.23, 0.4], [0.18, 0.02], [0, 0.02]] }",
    ),
    "file": (3, f"shape = {{ file = '{MUSEUM}/statue.stl' }}"),
    "feet": (
        3,
        "width = 0.9\nthickness = 0.5\nheight = 1.2\n"
        "feet = { inset = 0.02, size = 0.06, height = 0.1 }",
    ),
    "container": (3, "container = '40ft high cube'"),
}


def text_of(name: str, more: str = "") -> str:
    """A scene of a shape that is released tilted."""
    dimension, keys = SHAPES[name]
    return (
        f"dimension = {dimension}\n[[block]]\nmodel = 'rigid'\ndensity = 2000.0\n"
        f"tilt_deg = 8.0\n{keys}\n{more}\n"
        "[contact]\nfriction = 0.8\n[time]\nend = 0.3\nstep = 1e-3\n[output]\nevery = 0.1\n"
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Run]:
    """One of each shape, with files."""
    folder = tmp_path_factory.mktemp("shapes")
    for name in SHAPES:
        simulate(parse_scene(text_of(name)), folder=folder / name)
    return {name: read_run(folder / name) for name in SHAPES}


@pytest.mark.parametrize("name", SHAPES)
def test_pictures_are_made(name: str, runs: dict[str, Run], tmp_path: Path) -> None:
    """None is blank."""
    from PIL import Image

    assert main(["plot", str(runs[name].folder), "-o", str(tmp_path)]) == 0
    drawn = np.asarray(Image.open(tmp_path / "deformed.png").convert("RGB")).astype(int)
    assert np.ptp(drawn) > 200


@pytest.mark.parametrize("name", ["plane", "vase", "feet"])
def test_films_are_made(name: str, runs: dict[str, Run], tmp_path: Path) -> None:
    """With the edges of the shape."""
    from PIL import Image

    film = tmp_path / "film.gif"
    words = ["--until", "0.2", "--slow", "1", "--width", "320"]
    assert main(["animate", str(runs[name].folder), "-o", str(film), *words]) == 0
    frame = np.asarray(Image.open(film).convert("RGB")).astype(int)
    assert np.any(frame[70:-130] < 100, axis=2).sum() > 50  # edges


@pytest.mark.parametrize("name", SHAPES)
def test_fields_move_as_the_history_says(name: str, runs: dict[str, Run]) -> None:
    """ParaView's points, read back, are those of a rigid body at the places of the history."""
    import pyvista

    from geometry.skin import faces_of

    run = runs[name]
    (block,) = run.scene.blocks
    d = run.scene.dimension
    corners, faces = faces_of(block.shape, d)
    reader = pyvista.get_reader(str(run.folder / "fields.pvd"))
    assert len(reader.time_values) == 4
    for time in reader.time_values:
        reader.set_active_time_value(time)
        grid, _ = reader.read()  # and forces
        assert grid.n_cells == sum(len(face) - 2 for face in faces)
        placed = np.asarray(grid.points) + grid.point_data["displacement"]
        row = int(np.argmin(np.abs(run.history["time_s"] - time)))
        box = boxes(run.history, block)
        own = corners - np.array(block.shape.middle(d))
        expected = box.centres[row] + own @ box.frames[row].T
        np.testing.assert_allclose(placed[:, :d], expected, atol=1e-5)
    assert '"Surface"' in (run.folder / "open_in_paraview.py").read_text()


def test_a_rigid_cylinder_beside_a_meshed_block_has_fields(tmp_path: Path) -> None:
    """Its facets as triangles: it has other corners than a box."""
    import pyvista

    text = (
        "dimension = 3\n[[block]]\nname = 'drum'\nmodel = 'rigid'\ndensity = 2000.0\n"
        "height = 0.4\nshape = { cylinder = 0.2, sides = 8 }\n"
        "[[block]]\nname = 'cube'\nposition = [1.0, 0.0, 0.15]\nwidth = 0.3\nheight = 0.3\n"
        "thickness = 0.3\nmass = 50.0\nyoung = 1e9\npoisson = 0.2\ncells = [1, 1, 1]\n"
        "[time]\nend = 2e-3\nstep = 1e-3\n[output]\nevery = 2e-3\n"
    )
    simulate(parse_scene(text), folder=tmp_path / "out")
    reader = pyvista.get_reader(str(tmp_path / "out" / "fields.pvd"))
    reader.set_active_time_value(reader.time_values[-1])
    cells = sorted(grid.n_cells for grid in reader.read()[:-1])  # but forces
    assert cells == [1, 28]  # 16 of the side, 6 of each end


@pytest.mark.parametrize("name", SHAPES)
def test_forces_act_at_the_lowest_corner(name: str, runs: dict[str, Run]) -> None:
    """While it leans, at a place of its own that is on the ground."""
    from solver.pictures.contact import block_frames

    run = runs[name]
    (block,) = run.scene.blocks
    found = block_frames(run, block, np.array([0.0, 0.02]))
    np.testing.assert_allclose(found.push.place[:, -1], 0, atol=2e-3)
    placed = found.centres[0] + found.corners @ found.frames[0].T
    lowest = placed[placed[:, -1] < 1e-3]
    low, high = lowest.min(axis=0) - 1e-6, lowest.max(axis=0) + 1e-6
    assert ((found.push.place[0] >= low) & (found.push.place[0] <= high)).all()


def test_a_force_between_corners_is_below_the_centre() -> None:
    from solver.pictures.contact import _nearest_between

    up = np.array([0.0, 0.0, 1.0])
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    inside, outside = np.array([0.3, -0.2, 0.0]), np.array([2.0, 0.0, 0.0])
    np.testing.assert_allclose(_nearest_between(ring, inside, up), inside)
    np.testing.assert_allclose(_nearest_between(ring, outside, up), [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(_nearest_between(ring[:2], outside, up), ring[0], atol=1e-12)
    flat = np.array([[-1.0, 0.0], [0.5, 0.0], [0.4, 0.0]])
    found = _nearest_between(flat, np.array([0.2, 0.0]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(found, [0.2, 0.0], atol=1e-12)


def lines_of(name: str) -> dict[str, str]:
    """What `check` says, by the names of its lines."""
    found = {}
    for line in describe(parse_scene(text_of(name))).splitlines():
        key, _, value = line.strip().partition("  ")
        found.setdefault(key, value.strip())
    return found


def test_check_tells_of_shapes() -> None:
    assert lines_of("plane")["shape"] == "polygon: 2 convex parts, 8 sides"
    assert lines_of("bottle")["shape"] == "profile: convex, 98 facets"
    assert lines_of("bottle")["round"] == "48 facets, within the circle by at most 0.428 mm"
    feet = "4: 1.3 m high with them, 0.86 m over their outer edges along x"
    assert lines_of("feet")["feet"] == feet
    told = lines_of("container")
    assert told["block"] == "2.438 x 2.896 x 12.192 m, released from 8 degrees"
    assert told["container"] == "40ft high cube, on its corner castings"
    assert told["uplift at"] == "0.8419 g" and told["restitution"].startswith("0.3779")
    told = lines_of("file")
    assert told["shape"].startswith("file: a convex hull, ")
    assert told["surface"].startswith("3648 triangles; contacts see its convex hull, 6")
    assert "larger than its surface" in told["caution"]
    assert "give parts as shape.union" in told["caution"]
    assert "caution" not in lines_of("bottle")
    vase = lines_of("vase")
    assert vase["shape"] == "profile: 2 convex parts, 148 facets"
    more = r"contacts see its 2 convex parts, (\d+) % larger"
    found = re.search(more, vase["surface"])
    assert found is not None
    solid = parse_scene(text_of("vase")).blocks[0].shape.solid
    assert solid is not None and float(found[1]) == pytest.approx(100 * solid.hull_excess, abs=0.5)
    assert f"larger than its surface by {found[1]} % of its volume" in vase["caution"]
    assert "shape.union" not in vase["caution"]


def test_check_tells_by_how_much_a_fine_hull_is_off(tmp_path: Path) -> None:
    """1e-4 of 2 m, of a ball of more than 5000 points."""
    from pyvista import Sphere

    Sphere(radius=1.0, theta_resolution=120, phi_resolution=60).save(tmp_path / "ball.stl")
    text = text_of("file").replace(str(MUSEUM / "statue.stl"), str(tmp_path / "ball.stl"))
    told = next(line for line in describe(parse_scene(text)).splitlines() if "triangles" in line)
    said = r"its convex hull, 0\.0\d+ % smaller, without corners of less than 0\.2 mm$"
    assert re.search(said, told) is not None


def test_parts_of_a_file_are_those_that_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene means the same whether or not CoACD is installed."""
    cut = text_of("file").replace(".stl'", ".stl', contact = 'coacd'")
    monkeypatch.setitem(sys.modules, "coacd", None)
    with pytest.raises(SceneError) as refused:
        parse_scene(cut)
    said = 'block.shape.file: got contact = "coacd", which is not installed, allowed after `pip'
    assert str(refused.value).startswith(said)
    fake = SimpleNamespace(run_coacd=lambda mesh, seed: 1 / 0)
    monkeypatch.setitem(sys.modules, "coacd", fake)
    assert parse_scene(text_of("file")).blocks[0].shape.solid is not None


def test_alpha_of_a_shape_in_space_is_about_its_own_edge() -> None:
    """Of a bottle the radius of its foot over the height of its centre, whichever way it leans."""
    scene = parse_scene(text_of("bottle", "tilt_direction_deg = 40.0"))
    history = simulate(scene).history
    (block,) = scene.blocks
    expected = np.arctan2(0.2 * np.cos(np.pi / 48), block.shape.centre_height)
    np.testing.assert_allclose(slenderness(history, block), expected, rtol=3e-3)


def test_what_is_in_the_corner_of_an_l_overlaps_nothing() -> None:
    """Although the boxes around both do; a block within its arm does."""
    text = text_of("plane").replace("tilt_deg = 8.0", 'name = "l"')
    beside = (
        "[[block]]\nname = 'beside'\nmodel = 'rigid'\ndensity = 100.0\nwidth = 0.2\n"
        "height = 0.2\nthickness = 0.4\nposition = [0.2, 0.41]\n[contact]"
    )
    scene = parse_scene(text.replace("[contact]", beside))
    history = simulate(scene).history
    assert overlaps(scene, history) == []
    inside = {name: history[name] for name in scene_columns(scene)}
    inside["beside.centre_x_m"] = inside["beside.centre_x_m"] - 0.45  # into the post
    found = overlaps(scene, inside)
    assert [entry["blocks"] for entry in found] == [["l", "beside"]]
    assert found[0]["depth_m"] == pytest.approx(0.2, rel=0.05)


def test_the_museum_is_what_its_script_makes(tmp_path: Path) -> None:
    import subprocess
    import sys

    script = MUSEUM / "make_surfaces.py"
    subprocess.run([sys.executable, str(script), "--output", str(tmp_path)], check=True)
    for name in ("vase.stl", "statue.stl"):
        made, kept = ((folder / name).read_bytes() for folder in (tmp_path, MUSEUM))
        facets = [
            np.frombuffer(data[84:], np.dtype([("v", "<f4", 12), ("more", "<u2")]))["v"]
            for data in (made, kept)
        ]
        np.testing.assert_allclose(facets[0], facets[1], atol=1e-6)
    scene = load_scene(MUSEUM / "scene.toml")
    assert scene.blocks[-1].shape.mass == pytest.approx(5.59, abs=0.01)


def test_the_page_of_the_museum_says_what_check_prints() -> None:
    page = (ROOT / "docs" / "museum.md").read_text(encoding="utf-8")
    printed = [line.rstrip() for line in describe(load_scene(MUSEUM / "scene.toml")).splitlines()]
    shown = page.partition("says of the vase, among others,\n\n")[2].partition("\n\n")[0]
    lines = [line[4:] for line in shown.splitlines()]
    assert len(lines) == 6
    assert set(lines) <= set(printed)
    scene = (MUSEUM / "scene.toml").read_text(encoding="utf-8")
    first, _, rest = page.partition("each on the one before:\n\n")[2].partition("\n    ...\n")
    for text in (first, rest.partition("\n\nIts motion")[0]):
        assert "\n".join(line[4:] for line in text.strip("\n").splitlines()).strip() in scene
