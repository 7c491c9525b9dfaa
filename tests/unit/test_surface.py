"""Faces as carriers: facets in order, the same on every rank."""

from mpi4py import MPI

import basix.ufl
import numpy as np
import pytest
from dolfinx import fem, mesh
from refinement import outlines

from benchmarks.verification.disc_mesh import disc_mesh
from geometry.block import Block
from geometry.foundation import Plate
from geometry.gmsh_model import CELLS
from geometry.mesh import block_mesh, plate_mesh
from geometry.tags import FacetTag
from solver.contact.facets import carrier_surface

COMM = MPI.COMM_WORLD
SHAPE = Block(width=0.3, height=0.5, thickness=0.4, density=1000.0)


def space(made, degree):
    return fem.functionspace(made.mesh, ("Lagrange", degree, (made.mesh.geometry.dim,)))


@pytest.mark.parametrize("cell", CELLS[2])
@pytest.mark.parametrize("degree", [1, 2])
def test_facets_follow_the_tangent(cell, degree):
    made = block_mesh(SHAPE, cells=(4, 3), cell=cell, refinement=2.0, comm=COMM)
    starts = {
        FacetTag.TOP: ((-0.15, 0.5), (1, 0), 0.3),
        FacetTag.RIGHT: ((0.15, 0.5), (0, -1), 0.5),
        FacetTag.BOTTOM: ((0.15, 0.0), (-1, 0), 0.3),
        FacetTag.LEFT: ((-0.15, 0.0), (0, 1), 0.5),
    }
    for tag, (start, tangent, length) in starts.items():
        face = carrier_surface(space(made, degree), made.facet_tags, tag)
        count = 4 if tag in (FacetTag.TOP, FacetTag.BOTTOM) else 3
        assert (face.cell, face.degree, face.nodes.shape) == (
            "interval",
            degree,
            (count, degree + 1),
        )
        assert len(face.positions) == face.layer.size == count * degree + 1
        along = (face.positions[face.nodes] - start) @ tangent
        assert along[0, 0] == pytest.approx(0.0, abs=1e-14)
        assert along[-1, -1] == pytest.approx(length)
        np.testing.assert_array_equal(face.nodes[1:, 0], face.nodes[:-1, -1])
        assert np.all(np.diff((outlines(face) - start) @ tangent) > 0)
        assert len(outlines(face)) == count + 1
        steps = np.diff(along, axis=1)
        assert steps.min() > 0
        np.testing.assert_allclose(steps, steps[:, :1] * np.ones(degree), rtol=1e-12)


def test_a_curved_face_is_followed_round():
    made = disc_mesh(2.0, size=0.05, core=0.2, growth=1.3, comm=COMM)
    face = carrier_surface(space(made, 1), made.facet_tags, FacetTag.BOTTOM)
    x, y = (face.positions[face.nodes] - [0.0, 2.0]).reshape(-1, 2).T
    # Outward normals look down: their tangents lead from +x to -x.
    assert np.all(np.diff(np.arctan2(-x, -y)[::2]) > 0)
    np.testing.assert_allclose(np.hypot(x, y), 2.0, rtol=1e-14)


@pytest.mark.parametrize("cell", CELLS[3])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("tag", [FacetTag.TOP, FacetTag.LEFT, FacetTag.BACK])
def test_facets_in_space_look_outwards(cell, degree, tag):
    made = block_mesh(SHAPE, dimension=3, cells=(3, 2, 4), cell=cell, comm=COMM)
    face = carrier_surface(space(made, degree), made.facet_tags, tag)
    normal, area, boxes = {
        FacetTag.TOP: ((0, 0, 1), 0.3 * 0.4, (3, 2)),
        FacetTag.LEFT: ((-1, 0, 0), 0.4 * 0.5, (2, 4)),
        FacetTag.BACK: ((0, 1, 0), 0.3 * 0.5, (3, 4)),
    }[tag]
    triangles = cell == "tetrahedron"
    assert face.cell == ("triangle" if triangles else "quadrilateral")
    assert len(face.nodes) == np.prod(boxes) * (2 if triangles else 1)
    assert len(face.positions) == np.prod([degree * count + 1 for count in boxes])
    # The nodes are those of basix's element: its map covers the face, and has the right normal.
    element = basix.ufl.element("Lagrange", face.cell, degree)
    kind = basix.CellType[face.cell]
    points, weights = basix.make_quadrature(kind, 2)
    derivatives = element.tabulate(1, points)[1:]
    spanned = np.einsum("jqk,fki->fqji", derivatives, face.positions[face.nodes])
    outward = np.cross(spanned[:, :, 0], spanned[:, :, 1])
    total = np.einsum("q,fqi->i", weights, outward)
    np.testing.assert_allclose(total, area * np.array(normal), atol=1e-14)
    np.testing.assert_allclose(outward @ normal, np.linalg.norm(outward, axis=2), rtol=1e-12)
    corners = outlines(face)
    cut = corners[:, 1:-1] - corners[:, :1], corners[:, 2:] - corners[:, :1]
    assert (np.cross(*cut) @ normal).sum() / 2 == pytest.approx(area)  # corners in turn
    centres = face.positions[face.nodes].mean(axis=1).round(9)
    assert np.lexsort(centres.T[::-1]).tolist() == list(range(len(centres)))


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_layer_brings_the_values_of_all_ranks(dimension):
    plate = Plate(width=2.0, height=0.2, thickness=0.5)
    made = plate_mesh(plate, dimension=dimension, cells=(8, 2, 2)[:dimension], comm=COMM)
    V = space(made, 2)
    face = carrier_surface(V, made.facet_tags, FacetTag.TOP)
    owned = V.dofmap.index_map.size_local
    mine = V.tabulate_dof_coordinates()[:owned, :dimension]
    np.testing.assert_allclose(face.layer.gather(mine), face.positions, atol=1e-15)
    back = np.zeros_like(mine)
    face.layer.add(back, np.ones_like(face.positions))
    assert COMM.allreduce(back[:, 0].sum()) == len(face.positions)
    assert np.abs(face.positions[:, -1]).max() < 1e-15


def test_refuses_what_is_no_carrier():
    made = block_mesh(SHAPE, cells=(2, 2), comm=COMM)
    with pytest.raises(ValueError, match=r"no facets with tags \(7,\)"):
        carrier_surface(space(made, 1), made.facet_tags, FacetTag.FEET)
    with pytest.raises(ValueError, match="degree 3"):
        carrier_surface(space(made, 3), made.facet_tags, FacetTag.TOP)
    tags = made.facet_tags
    all_round = mesh.meshtags(made.mesh, 1, tags.indices, np.ones_like(tags.values))
    with pytest.raises(ValueError, match="in a circle"):
        carrier_surface(space(made, 1), all_round, 1)
