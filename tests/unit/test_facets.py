"""Rules of contact points on facets: exact, positive, on the pieces of cut facets."""

from mpi4py import MPI

import basix
import numpy as np
import pytest
from dolfinx import fem
from refinement import cut_by, outlines

from geometry.block import Block
from geometry.foundation import Plate
from geometry.gmsh_model import CELLS
from geometry.mesh import block_mesh, move, plate_mesh
from geometry.tags import FacetTag
from solver.contact.facets import carrier_surface
from solver.contact.nitsche_points import contact_points
from solver.contact.quadrature import facet_rule
from solver.scene.material import Material

COMM = MPI.COMM_WORLD
SHAPE = Block(width=0.3, height=0.5, thickness=0.4, density=1000.0)
PLATE = Plate(width=0.7, height=0.1, thickness=0.5)
MATERIAL = Material(young=2.0e9, poisson=0.3, density=1000.0)
FACETS = [basix.CellType.interval, basix.CellType.quadrilateral, basix.CellType.triangle]


def moment(facet, powers):
    """Integral of x^a y^b over the reference facet: closed form."""
    a, b = (*powers, 0)[:2]
    if facet == basix.CellType.triangle:
        factorial = [1, 1, 2, 6, 24, 120, 720]
        return factorial[a] * factorial[b] / factorial[a + b + 2]
    return 1 / (a + 1) / (b + 1)


@pytest.mark.parametrize("facet", FACETS, ids=lambda facet: facet.name)
@pytest.mark.parametrize(
    ("points", "degree"), [("nodes", 1), ("nodes", 2), ("gauss", 1), ("gauss", 2)]
)
def test_rules_are_positive_and_exact(facet, points, degree):
    triangle = facet == basix.CellType.triangle
    if triangle and points == "nodes" and degree == 2:
        with pytest.raises(ValueError, match="tetrahedra of degree 2"):
            facet_rule(points, degree, facet)
        return
    places, weights = facet_rule(points, degree, facet)
    assert weights.min() > 0
    # Gauss rules integrate products of two displacements, the nodes a displacement.
    exact = 2 * degree if points == "gauss" else degree
    powers = [(a, b) for a in range(exact + 1) for b in range(exact + 1 - a)]
    for a, b in powers if places.shape[1] == 2 else [(a, 0) for a in range(exact + 1)]:
        values = places[:, 0] ** a * (places[:, 1] ** b if b else 1.0)
        assert weights @ values == pytest.approx(moment(facet, (a, b)), rel=1e-13)
    if points == "nodes":
        count = {1: 2, 2: 4}[places.shape[1]] if degree == 1 else 3 ** places.shape[1]
        assert len(weights) == (3 if triangle else count)


TURN = np.array([[0.8, 0.0, 0.6], [0.36, 0.8, -0.48], [-0.48, 0.6, 0.64]])  # orthogonal


@pytest.mark.parametrize("cell", CELLS[3])
@pytest.mark.parametrize("other", CELLS[3])
@pytest.mark.parametrize("degree", [1, 2])
def test_facets_cut_by_polygons_integrate_on_the_common_refinement(cell, other, degree):
    made = block_mesh(SHAPE, dimension=3, cells=(2, 3, 1), cell=cell, comm=COMM)
    below = plate_mesh(PLATE, dimension=3, cells=(7, 5, 1), cell=other, comm=COMM)
    for body in (made, below):
        move(body.mesh, lambda points: points @ TURN.T)
    carrier = carrier_surface(
        fem.functionspace(below.mesh, ("Lagrange", 1, (3,))), below.facet_tags, FacetTag.TOP
    )
    V = fem.functionspace(made.mesh, ("Lagrange", degree, (3,)))
    found = contact_points(
        V, made.facet_tags, MATERIAL, points="gauss", gamma=100.0, cut=cut_by(outlines(carrier))
    )
    bottom = found.tag == FacetTag.BOTTOM
    x = found.reference[bottom] @ TURN[:, 0]
    weight = found.weight[bottom]
    assert weight.sum() == pytest.approx(SHAPE.width * SHAPE.thickness, rel=1e-12)
    assert weight @ x**2 == pytest.approx(0.4 * 0.3**3 / 12, rel=1e-12)
    # A hat on the plate's cells (of 0.1, from -0.35 on), not on the block's: only pieces get it.
    hat = np.clip(1 - np.abs(x - 0.05) / 0.1, 0, None)
    assert weight @ hat == pytest.approx(0.4 * 0.1, rel=1e-12)
    # Other faces stay whole.
    whole = contact_points(V, made.facet_tags, MATERIAL, points="gauss", gamma=100.0)
    np.testing.assert_array_equal(found.reference[~bottom], whole.reference[whole.tag != 1])


def test_what_nothing_is_opposite_to_has_no_points():
    made = block_mesh(SHAPE, dimension=3, cells=(2, 2, 1), comm=COMM)
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (3,)))
    # A triangle that covers half of the facet x > 0, y > 0, and looks out beyond two edges.
    triangle = np.array([[[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.4, 0.0]]])
    options = {"points": "gauss", "gamma": 100.0}
    found = contact_points(V, made.facet_tags, MATERIAL, cut=cut_by(triangle), **options)
    bottom = found.tag == FacetTag.BOTTOM
    inside = bottom & (found.reference[:, :2] > 0).all(axis=1)
    # The facet 0.15 x 0.2 lies in the triangle up to its far corner, on the triangle's edge.
    assert found.weight[inside].sum() == pytest.approx(0.15 * 0.2)
    triangle[0, 1, 0], triangle[0, 2, 1] = 0.15, 0.2
    found = contact_points(V, made.facet_tags, MATERIAL, cut=cut_by(triangle), **options)
    bottom = found.tag == FacetTag.BOTTOM
    inside = bottom & (found.reference[:, :2] > 0).all(axis=1)
    assert found.weight[inside].sum() == pytest.approx(0.15 * 0.2 / 2)
    assert found.weight[bottom].sum() == pytest.approx(0.15 * 0.2 * 3.5)
    away = contact_points(
        V, made.facet_tags, MATERIAL, cut=cut_by(triangle - [0, 0, 0.1]), **options
    )
    assert away.weight.sum() == pytest.approx(2 * (0.3 * 0.4 + 0.4 * 0.5 + 0.3 * 0.5))


def test_refuses_cuts_at_nodes():
    flat = block_mesh(SHAPE, cells=(1, 1), comm=COMM)
    V = fem.functionspace(flat.mesh, ("Lagrange", 1, (2,)))
    with pytest.raises(ValueError, match="got cuts with points at 'nodes'"):
        contact_points(
            V, flat.facet_tags, MATERIAL, points="nodes", gamma=100.0, cut=cut_by(np.zeros((1, 2)))
        )
