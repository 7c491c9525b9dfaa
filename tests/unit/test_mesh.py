"""The meshes of blocks and plates: counts, sizes, tags, grading; on any number of ranks."""

from mpi4py import MPI

import gmsh
import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import exterior_facet_indices

from geometry.arrangement import initial_position
from geometry.block import Block
from geometry.compat import geometry_nodes
from geometry.foundation import Plate
from geometry.grading import graded, graded_to_both_ends
from geometry.mesh import block_mesh, move, plate_mesh
from geometry.tags import FacetTag

SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=2680.0)
COMM = MPI.COMM_WORLD


def integral(form):
    return COMM.allreduce(fem.assemble_scalar(fem.form(form)))


def coordinates(made):
    """Those of all nodes, (n, d), on every rank."""
    count, dimension = made.mesh.geometry.index_map().size_local, made.mesh.geometry.dim
    return np.concatenate(COMM.allgather(made.mesh.geometry.x[:count, :dimension]))


def cell_corners(made):
    """Corners of all cells, (cells, k, d), on every rank."""
    dimension = made.mesh.topology.dim
    count = made.mesh.topology.index_map(dimension).size_local
    corners = made.mesh.geometry.x[geometry_nodes(made.mesh)[:count]][:, :, :dimension]
    return np.concatenate(COMM.allgather(corners))


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
@pytest.mark.parametrize("cells", [(1, 1), (6, 16), (5, 7)])
@pytest.mark.parametrize("refinement", [1.0, 4.0])
def test_counts_sizes_and_tags(cell, cells, refinement):
    made = block_mesh(SHAPE, cells=cells, cell=cell, refinement=refinement, comm=COMM)
    topology = made.mesh.topology
    per_box = 2 if cell == "triangle" else 1
    assert made.mesh.basix_cell().name == cell
    assert topology.index_map(2).size_global == per_box * cells[0] * cells[1]
    assert made.mesh.geometry.index_map().size_global == (cells[0] + 1) * (cells[1] + 1)
    x = ufl.SpatialCoordinate(made.mesh)
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    assert integral(fem.Constant(made.mesh, 1.0) * ufl.dx) == pytest.approx(0.25)
    assert integral(x[1] * ufl.dx) == pytest.approx(0.125)
    sides = {
        FacetTag.BOTTOM: (0.25, 0.0, 0.0),
        FacetTag.RIGHT: (1.0, 0.125, 0.5),
        FacetTag.TOP: (0.25, 0.0, 0.25),
        FacetTag.LEFT: (1.0, -0.125, 0.5),
    }
    for tag, (length, x_moment, y_moment) in sides.items():
        here = ds(int(tag))
        assert integral(fem.Constant(made.mesh, 1.0) * here) == pytest.approx(length)
        assert integral(x[0] * here) == pytest.approx(x_moment, abs=1e-14)
        assert integral(x[1] * here) == pytest.approx(y_moment, abs=1e-14)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("cells", [(1, 1, 1), (4, 2, 3), (3, 4, 5)])
@pytest.mark.parametrize("refinement", [1.0, 4.0])
def test_counts_sizes_and_tags_in_space(cell, cells, refinement):
    made = block_mesh(SHAPE, dimension=3, cells=cells, cell=cell, refinement=refinement, comm=COMM)
    topology = made.mesh.topology
    per_box = 5 if cell == "tetrahedron" else 1
    assert made.mesh.basix_cell().name == cell
    assert topology.index_map(3).size_global == per_box * np.prod(cells)
    assert made.mesh.geometry.index_map().size_global == np.prod(np.array(cells) + 1)
    x = ufl.SpatialCoordinate(made.mesh)
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    assert integral(fem.Constant(made.mesh, 1.0) * ufl.dx) == pytest.approx(0.1875)
    assert integral(x[2] * ufl.dx) == pytest.approx(0.1875 / 2)
    sides = {
        FacetTag.BOTTOM: (0.1875, (0.0, 0.0, 0.0)),
        FacetTag.RIGHT: (0.75, (0.125, 0.0, 0.5)),
        FacetTag.TOP: (0.1875, (0.0, 0.0, 1.0)),
        FacetTag.LEFT: (0.75, (-0.125, 0.0, 0.5)),
        FacetTag.FRONT: (0.25, (0.0, -0.375, 0.5)),
        FacetTag.BACK: (0.25, (0.0, 0.375, 0.5)),
    }
    for tag, (area, centre) in sides.items():
        here = ds(int(tag))
        assert integral(fem.Constant(made.mesh, 1.0) * here) == pytest.approx(area)
        for i in range(3):
            assert integral(x[i] * here) == pytest.approx(area * centre[i], abs=1e-14)


@pytest.mark.parametrize(
    ("dimension", "cell"), [(2, "quadrilateral"), (3, "hexahedron"), (3, "tetrahedron")]
)
def test_every_boundary_facet_has_a_tag(dimension, cell):
    made = block_mesh(SHAPE, dimension=dimension, cells=(3, 4, 2)[:dimension], cell=cell, comm=COMM)
    made.mesh.topology.create_connectivity(dimension - 1, dimension)
    outside = exterior_facet_indices(made.mesh.topology)
    assert set(outside) <= set(made.facet_tags.indices)


def test_refinement_is_the_ratio_of_edges():
    made = block_mesh(SHAPE, cells=(6, 16), refinement=8.0, comm=COMM)
    points = coordinates(made)
    x = np.unique(points[:, 0].round(12))
    y = np.unique(points[:, 1].round(12))
    assert np.diff(x).max() / np.diff(x).min() == pytest.approx(8.0, rel=1e-8)
    assert np.diff(y).max() / np.diff(y).min() == pytest.approx(8.0, rel=1e-8)
    assert np.diff(x).argmin() in (0, 5)
    assert np.diff(y).argmin() == 0


@pytest.mark.parametrize(
    ("dimension", "cell"),
    [(2, "quadrilateral"), (2, "triangle"), (3, "hexahedron"), (3, "tetrahedron")],
)
def test_mirror_image(dimension, cell):
    cells = (6, 4, 5) if dimension == 3 else (6, 5)
    made = block_mesh(SHAPE, dimension=dimension, cells=cells, cell=cell, refinement=3.0, comm=COMM)
    middles = cell_corners(made).mean(axis=1).round(12) + 0.0
    for axis in range(dimension - 1):
        mirror = np.ones(dimension)
        mirror[axis] = -1
        mirrored = middles * mirror + 0.0
        assert {tuple(m) for m in middles} == {tuple(m) for m in mirrored}
        assert coordinates(made)[:, axis].min() == -coordinates(made)[:, axis].max()


def test_simplices_meet_the_bottom_corners_in_numbers():
    flat = block_mesh(SHAPE, cells=(6, 16), cell="triangle", comm=COMM)
    solid = block_mesh(SHAPE, dimension=3, cells=(4, 2, 3), cell="tetrahedron", comm=COMM)
    for made, count in ((flat, 2), (solid, 4)):
        touching = cell_corners(made)
        points = coordinates(made)
        ends = (points.min(axis=0), points.max(axis=0))
        for sides in np.ndindex(*(2,) * (points.shape[1] - 1)):
            corner = [ends[side][axis] for axis, side in enumerate(sides)] + [0.0]
            there = np.isclose(touching, corner).all(axis=2).any(axis=1)
            assert there.sum() == count


def test_refinement_in_space_is_along_each_direction():
    made = block_mesh(SHAPE, dimension=3, cells=(6, 4, 5), refinement=8.0, comm=COMM)
    for axis, line in enumerate(coordinates(made).T):
        steps = np.diff(np.unique(line.round(12)))
        assert steps.max() / steps.min() == pytest.approx(8.0, rel=1e-8)
        assert steps.argmin() == 0
        assert (steps.argmax() == len(steps) - 1) == (axis == 2)


@pytest.mark.parametrize("cell", [None, "triangle", "tetrahedron"])
def test_plate(cell):
    plate = Plate(width=2.0, height=0.2, thickness=0.5)
    dimension = 3 if cell == "tetrahedron" else 2
    cells = (8, 4, 2) if dimension == 3 else (8, 2)
    made = plate_mesh(plate, dimension=dimension, cells=cells, cell=cell, comm=COMM)
    points = coordinates(made)
    depth = [] if dimension == 2 else [0.25]
    low, high = [-1.0, *(-y for y in depth), -0.2], [1.0, *depth, 0.0]
    np.testing.assert_allclose(points.min(axis=0), low, rtol=1e-15)
    np.testing.assert_allclose(points.max(axis=0), high, rtol=1e-15)
    x = ufl.SpatialCoordinate(made.mesh)
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    assert integral(fem.Constant(made.mesh, 1.0) * ds(int(FacetTag.TOP))) == pytest.approx(
        2.0 if dimension == 2 else 1.0
    )
    assert integral(x[dimension - 1] * ds(int(FacetTag.TOP))) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.diff(np.unique(points[:, 0].round(12))), 0.25)


def test_moved():
    made = block_mesh(SHAPE, dimension=3, cells=(2, 2, 2), comm=COMM)
    before = coordinates(made)
    pose = initial_position(SHAPE, (0.1, 0.2), 0.3, 0.5)
    move(made.mesh, pose)
    np.testing.assert_allclose(coordinates(made), pose(before), atol=1e-15)
    x = ufl.SpatialCoordinate(made.mesh)
    centre = [integral(x[i] * ufl.dx) / 0.1875 for i in range(3)]
    np.testing.assert_allclose(centre, pose(np.array([[0.0, 0.0, 0.5]]))[0], rtol=1e-12)


def test_grading():
    np.testing.assert_allclose(graded(4, 8.0), np.array([0, 1, 3, 7, 15]) / 15)
    np.testing.assert_allclose(graded_to_both_ends(6, 4.0), np.array([0, 1, 3, 7, 11, 13, 14]) / 14)
    np.testing.assert_array_equal(graded(1, 5.0), [0, 1])
    np.testing.assert_array_equal(graded_to_both_ends(2, 5.0), [0, 0.5, 1])
    np.testing.assert_array_equal(graded_to_both_ends(4, 1.0), [0, 0.25, 0.5, 0.75, 1])


@pytest.mark.parametrize(
    "options",
    [
        {"cells": (0, 3)},
        {"cell": "hexagon"},
        {"refinement": 0.5},
        {"refinement": np.nan},
        {"cells": (2, 2, 2)},
        {"dimension": 3},
        {"dimension": 3, "cells": (2, 2, 2), "cell": "triangle"},
        {"dimension": 4},
    ],
)
def test_refuses(options):
    with pytest.raises(ValueError, match="block_mesh"):
        block_mesh(SHAPE, comm=COMM, **options)


def test_plate_refuses():
    with pytest.raises(ValueError, match="plate_mesh"):
        plate_mesh(Plate(width=1.0, height=0.1), cells=(4,), comm=COMM)
    with pytest.raises(ValueError, match=r"Plate.height: got 0.0"):
        Plate(width=1.0, height=0.0)


def test_leaves_no_trace_in_gmsh():
    block_mesh(SHAPE, cells=(2, 2), comm=COMM)
    assert not gmsh.isInitialized()
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.model.add("mine")
        block_mesh(SHAPE, cells=(2, 2), comm=COMM)
        assert gmsh.isInitialized()
        assert "block" not in gmsh.model.list()
        assert "mine" in gmsh.model.list()
    finally:
        gmsh.finalize()
