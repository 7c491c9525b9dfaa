"""The half disc: on the circle, fine where it touches, of well-shaped cells."""

import math

from mpi4py import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import entities_to_geometry, exterior_facet_indices

from benchmarks.verification.disc_mesh import disc_mesh
from geometry.compat import geometry_nodes
from geometry.tags import FacetTag

COMM = MPI.COMM_WORLD
RADIUS, SIZE, CORE = 8.0, 0.05, 1.0


@pytest.fixture(scope="module")
def made():
    return disc_mesh(RADIUS, size=SIZE, core=CORE, growth=1.1, comm=COMM)


def integral(form):
    return COMM.allreduce(fem.assemble_scalar(fem.form(form)))


def corners(made):
    """Corners of this rank's cells in a ring, (cells, 4, 2)."""
    count = made.mesh.topology.index_map(2).size_local
    return made.mesh.geometry.x[geometry_nodes(made.mesh)[:count]][:, [0, 1, 3, 2], :2]


def facet_nodes(made, tag):
    """Ends of all facets with this tag, (facets, 2, 2), on every rank."""
    made.mesh.topology.create_connectivity(1, 2)
    count = made.mesh.topology.index_map(1).size_local
    facets = made.facet_tags.find(tag)
    mine = facets[facets < count]
    places = np.zeros((0, 2), dtype=np.int32)
    if len(mine):  # dolfinx 0.9 crashes on none
        places = entities_to_geometry(made.mesh, 1, mine)
    return np.concatenate(COMM.allgather(made.mesh.geometry.x[places][:, :, :2]))


def test_round_side_is_on_the_circle_and_flat_side_on_top(made):
    below, above = facet_nodes(made, FacetTag.BOTTOM), facet_nodes(made, FacetTag.TOP)
    np.testing.assert_allclose(np.hypot(below[..., 0], below[..., 1] - RADIUS), RADIUS, rtol=1e-14)
    np.testing.assert_allclose(above[..., 1], RADIUS, rtol=1e-14)
    assert np.abs(np.diff(above[..., 0])).sum() == pytest.approx(2 * RADIUS)
    made.mesh.topology.create_connectivity(1, 2)
    assert set(exterior_facet_indices(made.mesh.topology)) <= set(made.facet_tags.indices)
    area = integral(fem.Constant(made.mesh, 1.0) * ufl.dx)
    assert area == pytest.approx(math.pi * RADIUS**2 / 2, rel=5e-3)
    assert area < math.pi * RADIUS**2 / 2  # the facets are chords


def test_facets_of_the_core_have_the_given_size(made):
    ends = facet_nodes(made, FacetTag.BOTTOM)
    angles = np.sort(np.arctan2(ends[..., 0], RADIUS - ends[..., 1]), axis=1)
    within = np.abs(angles).max(axis=1) < CORE / RADIUS + 1e-9
    assert within.sum() == 2 * CORE / SIZE
    np.testing.assert_allclose(RADIUS * np.diff(angles[within]), SIZE, rtol=1e-7)
    assert np.abs(ends[within]).sum(axis=2).min() < 1e-15  # a node at the contact itself
    grown = np.sort(np.diff(angles[~within]).ravel())[2:]
    assert grown[0] > SIZE / RADIUS
    ratio = grown[2::2] / grown[:-2:2]
    assert np.all(ratio < 1.2)


def test_cells_are_well_shaped_and_mirrored(made):
    ring = corners(made)
    towards, back = np.roll(ring, -1, axis=1) - ring, np.roll(ring, 1, axis=1) - ring
    lengths = np.linalg.norm(towards, axis=2) * np.linalg.norm(back, axis=2)
    angles = np.degrees(np.arccos(np.sum(towards * back, axis=2) / lengths))
    assert angles.min() > 40
    assert angles.max() < 140
    middles = np.concatenate(COMM.allgather(ring.mean(axis=1))).round(9) + 0.0
    assert {tuple(m) for m in middles} == {tuple(m) for m in middles * [-1, 1] + 0.0}


@pytest.mark.parametrize(
    "options", [{"size": 0.0}, {"size": 2.0}, {"core": 3.0}, {"growth": 1.0}, {"radius": math.nan}]
)
def test_refuses(options):
    sizes = {"radius": RADIUS, "size": SIZE, "core": CORE, **options}
    with pytest.raises(ValueError, match="disc_mesh"):
        disc_mesh(sizes.pop("radius"), **sizes, comm=COMM)
