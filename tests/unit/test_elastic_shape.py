"""Keys of elastic shapes, their meshes, and the faces that contact sees."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geometry.foundation import face_frame
from geometry.shapes import cylinder, hull, polygon, prism, regular
from geometry.solid import Solid
from geometry.tags import FacetTag, tags_of_faces
from rockslip import Scene, parse_scene
from solver.errors import SceneError
from solver.run.describe import describe
from solver.scene.cells import default_cell_size, simplices

WEDGE = {"polygon": [[0.0, 0.0], [0.6, 0.0], [0.0, 0.9]]}
ELL = {"polygon": [[0.0, 0.0], [0.6, 0.0], [0.6, 0.2], [0.2, 0.2], [0.2, 0.9], [0.0, 0.9]]}
FEET = {"inset": 0.1, "size": 0.1, "height": 0.1}
STONE = {"density": 2400.0, "young": 1e9, "poisson": 0.2}


def scene(*blocks: dict[str, Any], **tables: Any) -> Scene:
    """A scene of blocks of stone."""
    base = {"block": [STONE | block for block in blocks], "time": {"end": 0.1, "step": 1e-3}}
    return parse_scene(base | tables)


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ({"shape": WEDGE, "cells": [4, 4]}, "block.cells applies to boxes only; a shape has a"),
        ({"shape": WEDGE, "cell": "triangle"}, "block.cell applies to boxes only; a shape has a"),
        ({"shape": WEDGE, "refinement": 2.0}, "block.refinement applies to boxes only; a shape"),
        ({"shape": WEDGE, "cell_size": 1.0}, "block.cell_size: got 1.0, allowed at most 0.9"),
        ({"shape": WEDGE, "cell_size": 0.0}, "block.cell_size: got 0.0, allowed cell_size > 0"),
        ({"width": 1.0, "height": 1.0, "cell_size": 0.1}, "block.cell_size applies to blocks with"),
        ({"shape": WEDGE, "centre_of_mass": [0.0, 0.3]}, "block.centre_of_mass applies to boxes,"),
        ({"shape": WEDGE, "inertia": 30.0}, "block.inertia applies to blocks with model"),
        ({"shape": WEDGE, "young": 1e4}, "block.young: got 10000, strained by"),
        (
            {"width": 1.0, "height": 1.0, "feet": FEET, "cells": [4, 4]},
            "block.cells applies to boxes only; on feet it has a cell_size",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(block: dict[str, Any], said: str) -> None:
    with pytest.raises(SceneError) as error:
        scene(block)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)


def test_quadratic_tetrahedra_need_gauss_points() -> None:
    block = {"shape": WEDGE, "thickness": 0.5, "degree": 2}
    with pytest.raises(SceneError, match=r"^block\.degree: got 2, allowed 1 for tetrahedra"):
        scene(block, dimension=3)
    scene(block, dimension=3, contact={"points": "gauss"})


def test_the_size_of_cells_is_filled_in_and_told() -> None:
    given = scene({"shape": WEDGE})
    block = given.blocks[0]
    assert block.cell_size == default_cell_size([0.6, 0.9]) == 0.0735
    assert block.cells is None and block.cell is None
    assert parse_scene(given.to_dict()) == given
    pytest.importorskip("dolfinx")
    assert "cell_size 0.0735 m" in describe(given)


def test_sizes_by_default_have_some_cells_in_all_directions() -> None:
    assert default_cell_size([1.0, 1.0]) == 0.1
    assert default_cell_size([0.1, 3.0]) == 0.025
    assert default_cell_size([1.0, 1.0, 1.0]) == 0.125
    assert default_cell_size([1.0, 1.0, 0.05]) == 0.025


def test_limits_take_the_bottom_and_the_shortest_edge() -> None:
    block = scene({"shape": WEDGE, "thickness": 0.5, "cell_size": 0.2}).blocks[0]
    assert block.shape.bottom_area == pytest.approx(0.3)
    assert block.mesh.corner_cell == (0.2, 0.2)
    drum = {"shape": {"regular": 50}, "width": 1.0, "cell_size": 0.2}
    edge = np.sin(np.pi / 50)
    assert scene(drum).blocks[0].mesh.corner_cell == pytest.approx([edge, edge])
    assert scene(drum).blocks[0].shape.bottom_area == pytest.approx(edge)


def test_faces_have_tags_of_their_own() -> None:
    assert tags_of_faces([-1.0, 0.5, 0.5]) == (FacetTag.BOTTOM, FacetTag.TOP, 11)
    assert tags_of_faces([0.0, 1.0, 0.0, -1.0]) == (9, FacetTag.TOP, 11, FacetTag.BOTTOM)


@pytest.mark.parametrize("normal", [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [2, -1, 3]])
def test_frames_of_faces_that_look_anywhere(normal: list[float]) -> None:
    unit = np.array(normal) / np.linalg.norm(normal)
    frame = face_frame(unit)
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert frame[0] == pytest.approx(unit)


SHAPES: dict[str, Solid] = {
    "hexagon": regular(6, 1.0, 2000.0, 0.5),
    "triangle": polygon([[0, 0], [1, 0], [0.3, 2]], 2000.0, 0.5),
    "prism": prism(polygon([[0, 0], [1, 0], [0.3, 2]], 2000.0, 0.5), 0.5),
    "tetrahedron": hull([[0, 0, 0], [1, 0, 0], [0.4, 0.9, 0], [0.3, 0.3, 1.1]], 2000.0),
    "cylinder": cylinder(1.0, 2.0, 12, 2000.0),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_mesh_has_the_mass_of_its_shape_and_its_size(name: str) -> None:
    """And so have its faces their areas, by their tags."""
    pytest.importorskip("dolfinx")
    import ufl
    from dolfinx.fem import assemble_scalar, form

    from geometry.mesh import shape_mesh

    (part,) = SHAPES[name].parts
    made = shape_mesh(part, 0.25)
    dx = ufl.Measure("dx", made.mesh)
    x = ufl.SpatialCoordinate(made.mesh)
    volume = assemble_scalar(form(1.0 * dx))
    assert volume == pytest.approx(part.moments.volume, rel=1e-12)
    for k, each in enumerate(part.moments.centre):
        assert assemble_scalar(form(x[k] * dx)) == pytest.approx(volume * each, abs=1e-12)
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    for face, tag in enumerate(tags_of_faces(part.normals[:, -1].tolist())):
        area = assemble_scalar(form(ufl.as_ufl(1.0) * ds(tag)))
        assert area == pytest.approx(part.area(face), rel=1e-12)
    cells = made.mesh.topology.index_map(part.dimension).size_global
    nodes = made.mesh.topology.index_map(0).size_global
    outside = sum(map(part.area, range(len(part.faces))))
    told = simplices(part.moments.volume, outside, 0.25, 1, 2 if part.dimension == 2 else 3)
    assert told == pytest.approx((cells, nodes), rel=0.6)  # a rough estimate


RING = np.array([[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [1.0, 2.0], [-0.5, 1.0]])


@pytest.mark.parametrize("turned_over", [False, True])
def test_distances_within_a_polygon(turned_over: bool) -> None:
    pytest.importorskip("dolfinx")
    from solver.contact.edge_crossings import distance_inside

    ring = RING[::-1] if turned_over else RING
    found = distance_inside(np.array([[1.0, 0.5], [1.0, -0.25], [0.5, 0.0], [2.0, 0.0]]), ring)
    assert found == pytest.approx([0.5, -0.25, 0.0, 0.0], abs=1e-15)


def test_the_edges_of_a_polygon_are_walked_round() -> None:
    """Anticlockwise as seen from above, also from the other side of the face."""
    pytest.importorskip("dolfinx")
    from geometry.foundation import level_frame
    from solver.contact.body_points import FixedPoints
    from solver.contact.edge_crossings import Outline

    corners = np.column_stack([RING, np.ones(5)])
    nodes = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
    points = FixedPoints(nodes[[7, 2, 9, 0, 3, 5, 1, 8, 6, 4]])
    for up in (1.0, -1.0):
        outline = Outline(points, 1, level_frame(3, up), (corners,))
        chords = outline.chords(points.reference)
        assert outline.count == 5
        assert np.cross(chords[0], chords[1])[2] * up > 0
        edge = np.repeat(np.arange(5), 3)
        fraction = np.tile([0.1, 0.5, 0.9], 5)
        segment, where = outline.locate(edge, fraction)
        spots = outline.spots(segment, where, points.reference).carried(points.reference)
        begins = points.reference[outline.corners]
        assert spots == pytest.approx(begins[edge] + fraction[:, None] * chords[edge])
        assert outline.fraction(edge, segment, where) == pytest.approx(fraction)


def test_faces_with_fewer_corners_have_their_own_normals() -> None:
    pytest.importorskip("dolfinx")
    from solver.contact.body_points import FixedPoints
    from solver.contact.hull import Hull

    for solid in (SHAPES["prism"], SHAPES["cylinder"]):
        (part,) = solid.parts
        placed = Hull(FixedPoints(part.corners), part.faces).placed(None)
        assert placed.normals == pytest.approx(part.normals, abs=1e-12)
        level = [
            part.corners[face[0]] @ n for face, n in zip(part.faces, part.normals, strict=True)
        ]
        assert placed.levels == pytest.approx(np.array(level), abs=1e-12)


def test_facets_belong_to_the_faces_of_the_hull_and_of_parts() -> None:
    """Of a box on feet: their bottoms are one face of the hull, sloping ones have no facets."""
    pytest.importorskip("dolfinx")
    from geometry.body_faces import faces_on_mesh
    from geometry.body_mesh import cells_of_parts

    feet = {"inset": 0.1, "size": 0.15, "height": 0.1}
    block = scene({"width": 1.0, "height": 0.5, "thickness": 0.8, "feet": feet}, dimension=3)
    solid = block.blocks[0].shape.solid
    assert solid is not None
    cells = cells_of_parts(solid.parts, 0.2)
    assert cells.volumes.sum() == pytest.approx(0.5 * 0.8 + 4 * 0.15**2 * 0.1, rel=1e-12)
    (whole, box, *pads), tags = faces_on_mesh(cells.points, cells.boundary, solid.parts)
    a, b, c = (cells.points[cells.boundary[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2

    def area(found: frozenset[int]) -> float:
        """Area of the facets with some tags, m2."""
        return float(areas[np.isin(tags, list(found))].sum())

    bottom, top = int(FacetTag.BOTTOM), int(FacetTag.TOP)
    assert area(whole.facets[bottom]) == pytest.approx(4 * 0.15**2, rel=1e-9)
    assert area(whole.facets[top]) == pytest.approx(0.8, rel=1e-9)
    spanning = [tag for tag in whole.loops if not whole.facets[tag]]
    assert len(spanning) == 4 and all(whole.points[tag] for tag in spanning)
    assert area(box.facets[bottom]) == pytest.approx(0.8 - 4 * 0.15**2, rel=1e-9)
    for pad in pads:
        assert area(pad.facets[bottom]) == pytest.approx(0.15**2, rel=1e-9)
        assert not pad.facets[top]
        sides = sum(area(pad.facets[tag]) for tag in pad.loops if tag not in (bottom, top))
        assert sides == pytest.approx(4 * 0.15 * 0.1, rel=1e-9)


def test_outlines_go_round_pieces() -> None:
    """Two bottoms of feet in space: eight corners, no more, whatever the cells are."""
    pytest.importorskip("dolfinx")
    from solver.build.assembly import build
    from solver.contact.surfaces import outline_of

    pads = [{"at": [x, 0.0], "size": 0.3, "height": 0.1} for x in (-0.3, 0.3)]
    given = scene(
        {"width": 1.0, "height": 0.5, "thickness": 0.5, "feet": pads, "cell_size": 0.12},
        dimension=3,
    )
    surface = build(given).members[0].surface
    face = surface.face(int(FacetTag.BOTTOM), 1e-9)
    assert face is not None and face.rings is not None
    assert [len(ring) for ring in face.rings] == [4, 4]
    edges = outline_of(face, np.array([0.0, 0.0, 1.0]))
    lengths = np.linalg.norm(edges.chords(edges.points.reference), axis=1)
    assert lengths == pytest.approx(np.full(8, 0.3), rel=1e-9)
    assert surface.face(surface.tags[next(iter(_spanning(surface)))], 1e-9) is None


def _spanning(surface: Any) -> list[int]:
    """Numbers of the faces of a surface that span a hollow."""
    return [k for k, tag in enumerate(surface.tags) if not surface.is_real(tag)]


def test_density_of_a_box_on_feet_is_above_them() -> None:
    """Its mass and centre on the mesh are those without feet, to a thousandth of these."""
    pytest.importorskip("dolfinx")
    from solver.build.assembly import build

    feet = {"inset": 0.05, "size": 0.1, "height": 0.1}
    block = {"width": 1.0, "height": 0.5, "thickness": 0.7, "feet": feet}
    for off in ({}, {"centre_of_mass": [0.05, 0.28]}):
        given = scene(block | off).blocks[0].shape
        body = build(scene(block | off)).members[0].body
        assert body.mass == pytest.approx(given.mass, rel=1e-12)
        assert body.centre == pytest.approx(given.centre_of_mass(), abs=1e-4)


def test_parts_of_other_densities_are_elastic() -> None:
    """Mass and centre of a union are those of its parts."""
    pytest.importorskip("dolfinx")
    from solver.build.assembly import build

    square = {"polygon": [[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.0, 0.4]]}
    union = {"union": [square, square | {"at": [0.0, 0.4], "density": 1200.0}]}
    given = scene({"shape": union})
    body = build(given).members[0].body
    assert body.mass == pytest.approx(0.16 * 3600.0, rel=1e-12)
    assert body.centre == pytest.approx([0.0, (2 * 0.2 + 0.6) / 3], abs=1e-12)


def test_cautions_for_hollows() -> None:
    """Where hulls meet though a body is hollow, and where a file is."""
    from solver.excitation.motion import read_ground
    from solver.results.cautions import cautions_of_input

    low = {"name": "low", "shape": ELL}
    top = {"name": "top", "on": "low", "width": 0.1, "height": 0.3, "offset": -0.2}
    given = scene(low, top)
    (said,) = cautions_of_input(given, read_ground(given))
    assert said.startswith("top and low, which carries it, meet by the faces of their convex hulls")
    feet = {"name": "feet", "on": "slab", "width": 0.8, "height": 0.3, "feet": FEET}
    fine = scene({"name": "slab", "width": 1.0, "height": 0.2}, feet)
    assert cautions_of_input(fine, read_ground(fine)) == []


def test_between_pieces_of_a_face_the_nearer_one_carries() -> None:
    """In the plane, by the margin on both sides of a gap; farther away none does."""
    pytest.importorskip("dolfinx")
    from geometry.foundation import level_frame
    from solver.contact.body_points import FixedPoints
    from solver.contact.carriers import Face

    places = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    points = FixedPoints(places)
    face = Face(points, np.array([[0, 1], [2, 3]]), level_frame(2), "interval", 1, 1e-5)
    at = [-1e-6, 1 + 1e-6, 1 + 1e-4, 1.5, 2 - 1e-4, 2 - 1e-6, 2.5, 3 + 1e-6]
    there = np.column_stack([at, np.full(8, 0.1)])
    found = face.kinematics(there, points.observe(None), face.reference_frame)
    assert found.place == pytest.approx(np.column_stack([np.full(8, 0.1), at]), abs=1e-12)
    beyond = face.beyond_edge(found)
    assert beyond is not None
    assert beyond.tolist() == [False, False, True, True, True, False, False, False]
