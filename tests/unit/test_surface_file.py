"""Files of surfaces: what is read from them against quadrature, and what is refused."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.shapes import of_surface
from geometry.surface import Surface, merged
from geometry.surface_file import read_surface

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
QUADS = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
FACETS = np.array([(q[0], q[k], q[k + 1]) for q in QUADS for k in (1, 2)])


def star_shaped(rings: int, around: int) -> tuple[Array, Indices]:
    """A made-up animal: a ball with two ears, a snout and a flat foot, seen from its middle."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = 2 * np.pi * np.arange(around) / around
    t, p = np.meshgrid(theta, phi, indexing="ij")
    grid = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1).reshape(-1, 3)
    ways = np.concatenate([grid, [[0, 0, 1], [0, 0, -1]]])
    radius = np.ones(len(ways))
    for ear in ([0.5, 0.3, 0.8], [0.5, -0.3, 0.8], [0.9, 0.0, 0.1]):
        radius += 0.7 * np.exp(-20 * (1 - ways @ (np.array(ear) / np.linalg.norm(ear))))
    radius = np.minimum(radius, 0.8 / np.maximum(-ways[:, 2], 1e-9))  # the foot, at z = -0.8
    top, below = len(grid), len(grid) + 1
    facets = []
    for k in range(around):
        m = (k + 1) % around
        facets += [(top, k, m), (below, (rings - 2) * around + m, (rings - 2) * around + k)]
        for row in range(rings - 2):
            a, b = row * around + k, row * around + m
            facets += [(a, a + around, b + around), (a, b + around, b)]
    return radius[:, None] * ways, np.array(facets)


def quadrature(points: Array, facets: Indices) -> tuple[float, Array, Array]:
    """Volume, centre and inertia about it as integrals over all directions from the origin.

    In a direction s the body reaches to r(s) and gives r^3/3, r^4/4 s, r^5/5 s s^T a solid angle;
    on a facet in the plane n.x = h, dw = h dA/r^3, which a rule of degree 5 with seven points sums.
    """
    corners = points[facets]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = np.einsum("ni,ni->n", across, corners[:, 0]) / 2  # h A
    root = math.sqrt(15)
    rule = [((1 / 3, 1 / 3, 1 / 3), 9 / 40)]
    for a, w in (((6 - root) / 21, (155 - root) / 1200), ((6 + root) / 21, (155 + root) / 1200)):
        rule += [((1 - 2 * a, a, a), w), ((a, 1 - 2 * a, a), w), ((a, a, 1 - 2 * a), w)]
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for shares, weight in rule:
        x = np.einsum("k,nki->ni", shares, corners)
        volume += float(weight * heights.sum()) / 3
        first += weight * heights @ x / 4
        second += weight * (heights[:, None] * x).T @ x / 5
    spread = second - np.outer(first, first) / volume
    return volume, first / volume, np.trace(spread) * np.eye(3) - spread


def write_binary(file: Path, points: Array, facets: Indices, head: bytes = b"solid") -> None:
    """A binary STL file; some programs begin those with `solid`, too."""
    with file.open("wb") as opened:
        opened.write(head.ljust(80) + struct.pack("<I", len(facets)))
        for corners in points[facets]:
            opened.write(struct.pack("<12fH", 0, 0, 0, *corners.reshape(-1), 0))


def write_ascii(file: Path, points: Array, facets: Indices, digits: int = 9) -> None:
    """An STL file of text."""
    lines = ["solid animal"]
    for corners in points[facets]:
        vertices = [f"vertex {x:.{digits}g} {y:.{digits}g} {z:.{digits}g}" for x, y, z in corners]
        lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    file.write_text("\n".join([*lines, "endsolid animal", ""]))


def write_obj(file: Path, points: Array, facets: Indices) -> None:
    """A Wavefront OBJ file, with a normal that differs from facet to facet at each point."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points] + ["vn 0 0 1", "vn 0 1 0"]
    lines += [
        f"f {a + 1}//{k % 2 + 1} {b + 1}//{k % 2 + 1} {c + 1}//{k % 2 + 1}"
        for k, (a, b, c) in enumerate(facets)
    ]
    file.write_text("\n".join(lines) + "\n")


def write_ply(file: Path, points: Array, facets: Indices) -> None:
    """A PLY file of text."""
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(facets)}", "property list uchar int vertex_indices", "end_header"]
    rows = [f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
    file.write_text("\n".join([*head, *rows, *(f"3 {a} {b} {c}" for a, b, c in facets), ""]))


def write_binary_ply(file: Path, points: Array, facets: Indices) -> None:
    """A binary PLY file, big end first, in double precision, with colours and edges besides."""
    head = ["ply", "format binary_big_endian 1.0", f"element vertex {len(points)}"]
    head += [*(f"property double {axis}" for axis in "xyz"), "property uchar red"]
    head += ["element edge 1", "property int vertex1", "property int vertex2"]
    head += [f"element face {len(facets)}", "property uchar flag"]
    head += ["property list uchar uint vertex_index", "end_header", ""]
    rows = [struct.pack(">3dB", *point, 7) for point in points] + [struct.pack(">2i", 0, 1)]
    rows += [struct.pack(">BB3I", 1, 3, *facet) for facet in facets]
    file.write_bytes("\r\n".join(head).encode() + b"".join(rows))


WRITERS = {
    "binary.stl": write_binary,
    "text.stl": write_ascii,
    "text.obj": write_obj,
    "text.ply": write_ply,
    "binary.ply": write_binary_ply,
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize(("rings", "around"), [(40, 60)])
def test_an_animal(name: str, rings: int, around: int, tmp_path: Path) -> None:
    """4680 facets in centimetres; mass, centre and inertia against a quadrature over directions."""
    points, facets = star_shaped(rings, around)
    WRITERS[name](tmp_path / name, points * 100, facets)
    surface = read_surface(tmp_path / name, scale=0.01)
    assert surface.triangles.shape == (2 * around * (rings - 1), 3)
    assert len(surface.points) == around * (rings - 1) + 2
    volume, centre, inertia = quadrature(points, facets)
    body = of_surface(surface, 2500.0)
    scale = 2500 * np.abs(inertia).max()
    assert body.mass == pytest.approx(2500 * volume, rel=1e-7)
    assert body.centre == pytest.approx(centre, abs=1e-7)
    assert np.asarray(body.inertia) == pytest.approx(2500 * inertia, abs=1e-7 * scale)
    assert 0.05 < body.hull_excess < 0.5
    assert len(body.bottom) > 10 and body.low[2] == pytest.approx(-0.8, abs=1e-7)
    foot = [face for face, n in zip(body.parts[0].faces, body.parts[0].normals, strict=True)
            if n[2] < -0.999999]  # fmt: skip
    assert len(foot) == 1 and len(foot[0]) == len(body.bottom)
    assert body.standing().low[2] == 0.0


def test_a_ball_tends_to_its_closed_form() -> None:
    """Errors of volume and inertia fall by four with twice as many facets around."""
    errors = []
    for rings in (20, 40):
        theta, phi = np.pi * np.arange(rings + 1) / rings, np.pi * np.arange(2 * rings) / rings
        points, facets = star_shaped(rings, 2 * rings)
        points = points / np.linalg.norm(points, axis=1)[:, None]
        surface = Surface(points=points, triangles=facets)
        errors.append(1 - surface.volume / (4 / 3 * np.pi))
        assert surface.moments.centre == pytest.approx(np.zeros(3), abs=1e-14)
        assert len(theta) == rings + 1 and len(phi) == 2 * rings
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("name", WRITERS)
def test_a_cube_has_six_faces(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name, CUBE * 0.3 + 0.1, FACETS)
    body = of_surface(read_surface(tmp_path / name), 1000.0)
    assert [len(face) for face in body.parts[0].faces] == [4] * 6
    assert len(body.corners) == 8 and len(body.bottom) == 4
    assert body.mass == pytest.approx(27.0, rel=1e-6)
    assert body.hull_excess == pytest.approx(0.0, abs=1e-6)


def test_points_that_differ_in_the_last_digit_are_one(tmp_path: Path) -> None:
    points = CUBE[FACETS].reshape(-1, 3)
    points = points + 2e-10 * np.random.default_rng(0).normal(size=points.shape)
    joined, facets = merged(points, np.arange(len(points)).reshape(-1, 3))
    assert len(joined) == 8 and len(facets) == 12
    assert Surface(points=joined, triangles=facets).volume == pytest.approx(1.0, rel=1e-8)


def test_facets_without_an_area_are_left_out(tmp_path: Path) -> None:
    write_ascii(tmp_path / "a.stl", CUBE, np.array([*FACETS, (0, 0, 1), (2, 2, 2)]))
    assert len(read_surface(tmp_path / "a.stl").triangles) == 12


def test_a_body_inside_out_is_turned(tmp_path: Path) -> None:
    write_binary(tmp_path / "a.stl", CUBE, FACETS[:, ::-1])
    assert read_surface(tmp_path / "a.stl").volume == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("points", "faces"),
    [
        ("v {} {} {} 0.1 0.2 0.3", "f {}/1 {}/1 {}/1 {}/1"),  # colours, and texture
        ("v {} {} {}", "usemtl wood\ns 1\nf {}//2 {}//2 {}//2 {}//2"),
        ("v {} {} {} 1.0", "f {} {} {} \\\n{}"),
    ],
)
def test_what_obj_files_hold_besides(points: str, faces: str, tmp_path: Path) -> None:
    lines = ["mtllib none.mtl", *(points.format(*place) for place in CUBE)]
    lines += ["vt 0 0", "vn 0 0 1", "vn 0 1 0"]
    lines += [faces.format(*(k + 1 for k in quad)) for quad in QUADS]
    (tmp_path / "a.obj").write_text("\r\n".join(lines).replace("\\\n", "\\\r\n"))
    assert read_surface(tmp_path / "a.obj").volume == pytest.approx(1.0)


# ----------------------------------------------------------------------------------- meshes


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A half-cylinder R 0.5, h 1 as meshes of Gmsh, and as an unstructured grid of VTK."""
    import gmsh
    import pyvista

    folder = tmp_path_factory.mktemp("meshes")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("half")
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 1, 0.5, angle=math.pi)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(folder / "facets.msh"))
        gmsh.model.mesh.generate(3)
        gmsh.write(str(folder / "cells.msh"))
        gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
        gmsh.option.setNumber("Mesh.Binary", 1)
        gmsh.write(str(folder / "old.msh"))
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(folder / "second.msh"))
        gmsh.model.add("bricks")
        base = gmsh.model.occ.addRectangle(0, 0, 0, 1, 2)
        made = gmsh.model.occ.extrude([(2, base)], 0, 0, 3, numElements=[2], recombine=True)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        assert made
        gmsh.write(str(folder / "wedges.msh"))
        gmsh.model.mesh.clear()
        for line in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(line[1], 3)
        for face in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(face[1])
            gmsh.model.mesh.setRecombine(2, face[1])
        gmsh.model.mesh.setTransfiniteVolume(1)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(folder / "bricks.msh"))
    finally:
        gmsh.finalize()
    cells = np.array([[8, 0, 1, 2, 3, 4, 5, 6, 7]])
    grid = pyvista.UnstructuredGrid(cells, np.array([12]), CUBE * [1, 2, 3])
    grid.save(folder / "bricks.vtu")
    tetrahedra = np.array([[4, 0, 2, 1, 5], [4, 0, 1, 3, 5]])  # the first has a negative volume
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 0], [0, 0, 1]])
    tetrahedra[1] = [4, 0, 2, 3, 5]
    pyvista.UnstructuredGrid(tetrahedra, np.array([10, 10]), points).save(folder / "cells.vtu")
    return folder


@pytest.mark.parametrize("name", ["facets.msh", "cells.msh", "old.msh", "second.msh"])
def test_meshes_of_gmsh(name: str, meshes: Path) -> None:
    surface = read_surface(meshes / name)
    assert surface.volume == pytest.approx(math.pi / 8, rel=0.05)
    assert surface.points.min(axis=0) == pytest.approx([-0.5, 0, 0], abs=1e-9)
    assert surface.points.max(axis=0) == pytest.approx([0.5, 0.5, 1], abs=1e-3)
    other = read_surface(meshes / "facets.msh")
    assert surface.volume == pytest.approx(other.volume, rel=1e-12)


@pytest.mark.parametrize("name", ["wedges.msh", "bricks.msh", "bricks.vtu"])
def test_cells_that_are_no_tetrahedra(name: str, meshes: Path) -> None:
    surface = read_surface(meshes / name)
    assert surface.volume == pytest.approx(6.0, rel=1e-12)
    assert surface.moments.centre == pytest.approx([0.5, 1.0, 1.5], rel=1e-12)


def test_tetrahedra_whichever_way_their_corners_go(meshes: Path) -> None:
    surface = read_surface(meshes / "cells.vtu")
    assert surface.volume == pytest.approx(1 / 3, rel=1e-12)
    assert len(surface.triangles) == 6


def test_gmsh_is_left_as_it_was(meshes: Path) -> None:
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("mine")
        read_surface(meshes / "cells.msh")
        assert gmsh.model.getCurrent() == "mine" and gmsh.isInitialized()
        assert gmsh.model.list() == ["", "mine"]
    finally:
        gmsh.finalize()
    assert not gmsh.isInitialized()


# ----------------------------------------------------------------------------------- shells


def shells(*placed: tuple[list[float], float, bool]) -> Surface:
    """Cubes with lower corners, sides, and facets inwards or not."""
    points = [CUBE * side + np.array(corner) for corner, side, _ in placed]
    facets = [
        (FACETS[:, ::-1] if inwards else FACETS) + 8 * k for k, (_, _, inwards) in enumerate(placed)
    ]
    return Surface(points=np.concatenate(points), triangles=np.concatenate(facets))


@pytest.mark.parametrize(
    ("placed", "volume"),
    [
        ([([0, 0, 0], 1, False), ([2, 0, 0], 1, False)], 2.0),
        ([([0, 0, 0], 1, False), ([2, 0, 0], 1, True)], 2.0),  # no doubt: turned
        ([([0, 0, 0], 1, False), ([1, 0, 0], 1, False)], 2.0),  # they touch
        ([([0, 0, 0], 1, False), ([1, 0.2, 0.3], 0.5, False)], 1.125),
        ([([0, 0, 0], 1, False), ([0.2, 0.2, 0.2], 0.5, True)], 0.875),  # a cavity
        ([([0.2, 0.2, 0.2], 0.5, False), ([0, 0, 0], 1, True)], 0.875),  # the same inside out
        ([([0, 0, 0], 4, False), ([1, 1, 1], 2, True), ([1.5, 1.5, 1.5], 1, False)], 57.0),
    ],
)
def test_several_shells(placed: list[tuple[list[float], float, bool]], volume: float) -> None:
    assert shells(*placed).volume == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize(
    ("placed", "said"),
    [
        ([([0, 0, 0], 1, False), ([0.5, 0.5, 0.5], 1, False)], "two shells that overlap, near"),
        ([([0, 0, 0], 1, False), ([0.5, 0.2, 0.2], 0.6, True)], "two shells that overlap, near"),
        ([([0, 0, 0], 1, False), ([0.2, 0.2, 0.2], 0.5, False)], "a shell within another"),
        ([([0, 0, 0], 1, False), ([0.0, 0.0, 0.0], 1, False)], "shell"),
    ],
)
def test_shells_that_overlap(placed: list[tuple[list[float], float, bool]], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        shells(*placed)


# --------------------------------------------------------------------------------- refusals


def write_cube(file: Path, points: Array = CUBE, facets: Indices = FACETS) -> Path:
    """A cube as a binary file."""
    write_binary(file, points, facets)
    return file


TURNED = np.array([FACETS[0][::-1], *FACETS[1:]])


@pytest.mark.parametrize(
    ("points", "facets", "said"),
    [
        (CUBE, FACETS[1:], r"got 3 open edges, one at \[.*\], allowed a closed surface"),
        (CUBE, TURNED, r"turned round beside 3 edges, one at \[.*\], allowed all anticlockwise"),
        (CUBE * 1800, FACETS, "body of 1800 m, .* looks like millimetres: scale = 0.001"),
        (CUBE * [1, 1, 0], FACETS, "open edges|volume"),
        (CUBE * np.nan, FACETS, r"got \[nan, nan, nan\] as a point, allowed finite numbers"),
        (CUBE * 0, FACETS, "facets without an area only"),
        (CUBE, FACETS[:0], "got no facets, allowed a closed surface"),
    ],
)
def test_no_body_in_a_file(points: Array, facets: Indices, said: str, tmp_path: Path) -> None:
    file = write_cube(tmp_path / "a.stl", points, facets)
    with pytest.raises(ValueError, match=said) as refused:
        read_surface(file)
    assert str(refused.value).startswith(f"{file}: ") and "\n" not in str(refused.value)


def test_a_flat_surface_has_no_volume() -> None:
    with pytest.raises(ValueError, match=r"got the volume .* m3, allowed a body with one"):
        Surface(points=CUBE * [1, 1, 0], triangles=FACETS)


PLY = b"ply\nformat ascii 1.0\ncomment one facet\nelement vertex 3\nproperty float x\n"
PLY += b"property float y\nproperty float z\nelement face 1\n"
PLY += b"property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"

CONTENTS: dict[str, tuple[bytes, str]] = {
    "empty.stl": (b"", "got an empty file"),
    "text.stl": (b"solid a\nendsolid a\n", "got no facets"),
    "noise.stl": (bytes(range(256)) * 3, "bytes, .* facets announced, allowed an STL file"),
    "short.stl": (b" " * 80 + struct.pack("<I", 12) + b"\0" * 100, "184 bytes, 12 facets"),
    "tiny.stl": (b"ab", "2 bytes, 0 facets announced"),
    "word.stl": (b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 1\n", "got .* allowed"),
    "huge.stl": (b" " * 80 + struct.pack("<I", 2**31) + b"\0" * 50, "facets announced"),
    "empty.obj": (b"", "got an empty file"),
    "words.obj": (b"hello\nworld\n", "got .* allowed"),
    "far.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "got .* allowed"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\n", "no facets"),
    "words.ply": (b"hello\nworld\n", "got .* allowed"),
    "short.ply": (b"ply\nformat ascii 1.0\nelement vertex 8\n", "got .* allowed"),
    "none.ply": (b"ply\nformat ascii 1.0\nend_header\n", "no facets"),
    "many.ply": (PLY.replace(b"vertex 3", b"vertex many"), "got 'element vertex many' in its head"),
    "most.ply": (PLY.replace(b"vertex 3", b"vertex 99999999999"), "rows of 'vertex', allowed at"),
    "plane.ply": (
        PLY.replace(b"property float z\n", b""),
        "got points with x, y, allowed x, y and",
    ),
    "cut.ply": (PLY[:-9], "ends too early"),
    "word.ply": (PLY.replace(b"0 1 0", b"0 one 0"), "got .*one.*allowed numbers"),
    "far.ply": (PLY.replace(b"3 0 1 2", b"3 0 1 9"), "got a facet with point 9, allowed 0 to 2"),
    "open.ply": (PLY, "got 3 open edges"),
    "nothing.ply": (PLY.replace(b"ascii", b"binary_big_endian"), "ends too early"),
    "words.msh": (b"hello\nworld\n", "got .* allowed"),
    "short.msh": (b"$MeshFormat\n4.1 0 8\n", "got .* allowed"),
    "words.vtu": (b"hello\nworld\n", "got .* allowed"),
    "short.vtu": (b"<?xml version='1.0'?>\n<VTKFile type='Unstr", "got .* allowed"),
    "statue.blend": (b"BLENDER", r"of the kind '.blend', allowed .stl, .obj, .ply, .msh, .vtu"),
}


@pytest.mark.parametrize("name", CONTENTS)
def test_files_that_are_none(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Each in one line with its path, and no word of a library on the screen."""
    content, said = CONTENTS[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=said) as refused:
        read_surface(tmp_path / name)
    assert str(refused.value).startswith(f"{tmp_path / name}: ") and "\n" not in str(refused.value)
    heard = capfd.readouterr()
    assert heard.out == "" and heard.err == ""


def test_files_that_cannot_be_opened(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="got no such file or directory, allowed a file to read"):
        read_surface(tmp_path / "none.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(ValueError, match="got is a directory, allowed a file to read"):
        read_surface(tmp_path / "folder.stl")


@pytest.mark.parametrize("scale", [0.0, -1.0, math.nan])
def test_no_scale(scale: float, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"scale: got .*, allowed a number > 0"):
        read_surface(write_cube(tmp_path / "a.stl"), scale)


def test_too_many_facets_are_not_even_read(tmp_path: Path) -> None:
    """A sparse file of 1.1 10^6 facets; those of other kinds are counted when they are read."""
    with (tmp_path / "a.stl").open("wb") as opened:
        opened.write(b" " * 80 + struct.pack("<I", 1_100_000))
        opened.truncate(84 + 50 * 1_100_000)
    with pytest.raises(ValueError, match=r"a.stl: .*got 1100000 facets, allowed at most 1000000"):
        read_surface(tmp_path / "a.stl")
    with pytest.raises(ValueError, match="surface: got 1100000 facets"):
        Surface(points=CUBE, triangles=np.zeros((1_100_000, 3), dtype=np.int64))


@pytest.mark.parametrize(
    ("facets", "said"),
    [
        (FACETS + 1, "facets with points 1 to 8, allowed 0 to 7"),
        (FACETS[:, :2], r"got facets \(12, 2\), allowed \(m, 3\)"),
        (np.array([*FACETS, (0, 0, 1)]), "facet 12 with a point twice"),
    ],
)
def test_no_surface(facets: Indices, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Surface(points=CUBE, triangles=facets)
