"""The mesh of a block: counts, sizes, tags, grading; on any number of ranks."""

from mpi4py import MPI

import gmsh
import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import exterior_facet_indices

from geometry.block import Block
from geometry.mesh import block_mesh, graded, graded_to_both_ends
from geometry.tags import CellTag, FacetTag

SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=2680.0)
COMM = MPI.COMM_WORLD


def integral(form):
    return COMM.allreduce(fem.assemble_scalar(fem.form(form)))


def coordinates(made):
    """Those of all nodes, (n, 2), on every rank."""
    count = made.mesh.geometry.index_map().size_local
    return np.concatenate(COMM.allgather(made.mesh.geometry.x[:count, :2]))


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
    assert set(made.cell_tags.values) <= {CellTag.BLOCK}
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


def test_every_boundary_facet_has_a_tag():
    made = block_mesh(SHAPE, cells=(3, 4), comm=COMM)
    made.mesh.topology.create_connectivity(1, 2)
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


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
def test_mirror_image(cell):
    made = block_mesh(SHAPE, cells=(6, 5), cell=cell, refinement=3.0, comm=COMM)
    x = made.mesh.geometry.x
    count = made.mesh.topology.index_map(2).size_local
    mine = x[made.mesh.geometry.dofmap[:count]].mean(axis=1)[:, :2]
    middles = np.concatenate(COMM.allgather(mine)).round(12) + 0.0
    mirrored = middles * [-1, 1] + 0.0
    assert {tuple(m) for m in middles} == {tuple(m) for m in mirrored}
    assert coordinates(made)[:, 0].min() == -coordinates(made)[:, 0].max()


def test_triangles_meet_the_bottom_corners_in_pairs():
    made = block_mesh(SHAPE, cells=(6, 16), cell="triangle", comm=COMM)
    count = made.mesh.topology.index_map(2).size_local
    corners = made.mesh.geometry.x[made.mesh.geometry.dofmap[:count]][:, :, :2]
    for corner in ([-0.125, 0.0], [0.125, 0.0]):
        touching = np.isclose(corners, corner).all(axis=2).any(axis=1).sum()
        assert COMM.allreduce(int(touching)) == 2


def test_grading():
    np.testing.assert_allclose(graded(4, 8.0), np.array([0, 1, 3, 7, 15]) / 15)
    np.testing.assert_allclose(graded_to_both_ends(6, 4.0), np.array([0, 1, 3, 7, 11, 13, 14]) / 14)
    np.testing.assert_array_equal(graded(1, 5.0), [0, 1])
    np.testing.assert_array_equal(graded_to_both_ends(2, 5.0), [0, 0.5, 1])
    np.testing.assert_array_equal(graded_to_both_ends(4, 1.0), [0, 0.25, 0.5, 0.75, 1])


@pytest.mark.parametrize(
    "options", [{"cells": (0, 3)}, {"cell": "hexagon"}, {"refinement": 0.5}, {"refinement": np.nan}]
)
def test_refuses(options):
    with pytest.raises(ValueError, match="block_mesh"):
        block_mesh(SHAPE, comm=COMM, **options)


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
