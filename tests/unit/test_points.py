"""Contact points of meshed bodies in the plane and in space, against closed forms."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import fem

from geometry.block import Block
from geometry.gmsh_model import CELLS
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.contact.nitsche_points import contact_points
from solver.scene.material import Material
from tests.surfaces import evaluated, traction_gradient

COMM = MPI.COMM_WORLD
SHAPE = Block(width=0.3, height=0.5, thickness=0.4, density=1000.0)
MATERIALS = {
    2: Material(young=2.0e9, poisson=0.3, density=1000.0, plane="strain"),
    3: Material(young=2.0e9, poisson=0.3, density=1000.0, plane="solid"),
}
COUNTS = {2: (3, 4), 3: (3, 2, 3)}
KINDS = [(dimension, cell) for dimension in (2, 3) for cell in CELLS[dimension]]
NORMALS = {
    2: {1: (0, -1), 2: (1, 0), 3: (0, 1), 4: (-1, 0)},
    3: {1: (0, 0, -1), 2: (1, 0, 0), 3: (0, 0, 1), 4: (-1, 0, 0), 5: (0, -1, 0), 6: (0, 1, 0)},
}
CASES = [
    (dimension, cell, degree, points)
    for dimension, cell in KINDS
    for degree in (1, 2)
    for points in ("nodes", "gauss")
    if (cell, degree, points) != ("tetrahedron", 2, "nodes")
]


def surface(dimension, cell, degree, points, refinement=2.0, cells=None):
    made = block_mesh(
        SHAPE,
        dimension=dimension,
        cells=cells or COUNTS[dimension],
        cell=cell,
        refinement=refinement,
        comm=COMM,
    )
    V = fem.functionspace(made.mesh, ("Lagrange", degree, (dimension,)))
    material = MATERIALS[dimension]
    return contact_points(V, made.facet_tags, material, points=points, gamma=100.0)


def areas(dimension):
    """Of the faces, with their centres of area."""
    b, h = SHAPE.width, SHAPE.height
    if dimension == 2:
        return {1: (b, (0, 0)), 2: (h, (b / 2, h / 2)), 3: (b, (0, h)), 4: (h, (-b / 2, h / 2))}
    t = SHAPE.thickness
    return {
        1: (b * t, (0, 0, 0)),
        2: (t * h, (b / 2, 0, h / 2)),
        3: (b * t, (0, 0, h)),
        4: (t * h, (-b / 2, 0, h / 2)),
        5: (b * h, (0, -t / 2, h / 2)),
        6: (b * h, (0, t / 2, h / 2)),
    }


@pytest.mark.parametrize(("dimension", "cell", "degree", "points"), CASES)
def test_weights_are_those_of_the_faces(dimension, cell, degree, points):
    found = surface(dimension, cell, degree, points)
    for tag, (area, centre) in areas(dimension).items():
        here = found.tag == tag
        assert found.weight[here].sum() == pytest.approx(area, rel=1e-12)
        mean = found.weight[here] @ found.reference[here] / area
        np.testing.assert_allclose(mean, centre, atol=1e-12)
        expected = np.broadcast_to(NORMALS[dimension][tag], (here.sum(), dimension))
        np.testing.assert_allclose(found.normal[here], expected, atol=1e-12)
    assert found.weight.min() > 0


@pytest.mark.parametrize(("dimension", "cell", "degree", "points"), CASES)
def test_exact_traction_of_an_affine_displacement(dimension, cell, degree, points):
    found, material = surface(dimension, cell, degree, points), MATERIALS[dimension]
    gradient = np.random.default_rng(3).uniform(-0.2, 0.2, (dimension, dimension))
    shift = np.arange(1.0, dimension + 1)
    state = evaluated(found, found.node_positions @ gradient.T + shift)
    deformation = np.eye(dimension) + gradient
    strain = (deformation.T @ deformation - np.eye(dimension)) / 2
    lame, shear = material.lame, material.shear
    stress = lame * np.trace(strain) * np.eye(dimension) + 2 * shear * strain
    scale = np.abs(stress).max()
    expected = found.normal @ (deformation @ stress).T
    np.testing.assert_allclose(state.traction, expected, atol=1e-11 * scale)
    np.testing.assert_allclose(state.position, found.reference @ deformation.T + shift, atol=1e-13)


@pytest.mark.parametrize(("dimension", "cell", "degree", "points"), CASES)
def test_rows_are_the_derivatives_of_the_undeformed_body(dimension, cell, degree, points):
    found = surface(dimension, cell, degree, points)
    step = np.random.default_rng(4).uniform(-1.0, 1.0, (found.layer.size, dimension))
    small = 1e-7 * step  # second order in the strain: 1e-7 of the result
    ahead, behind = evaluated(found, small), evaluated(found, -small)
    traction = (ahead.traction - behind.traction) / 2e-7
    linear = (found.traction_rows() @ step.ravel()).reshape(-1, dimension)
    np.testing.assert_allclose(linear, traction, atol=1e-6 * np.abs(traction).max())
    moved = (found.position_rows() @ step.ravel()).reshape(-1, dimension)
    np.testing.assert_allclose(evaluated(found, step).position - found.reference, moved, atol=1e-12)


@pytest.mark.parametrize(("dimension", "cell", "degree", "points"), CASES)
def test_discrete_gradient_of_the_traction(dimension, cell, degree, points):
    found = surface(dimension, cell, degree, points)
    random = np.random.default_rng(5)
    states = random.uniform(-0.02, 0.02, (2, found.layer.size, dimension))
    direction = random.uniform(-1.0, 1.0, states[0].shape)
    vector = random.uniform(-1.0, 1.0, (found.count, dimension))
    old, new = (evaluated(found, state) for state in states)
    # Along the step it is exactly the difference of the tractions ...
    pull = traction_gradient(found, old, new, vector)
    work = np.sum(pull * (states[1] - states[0]))
    assert work == pytest.approx(np.sum(vector * (new.traction - old.traction)), rel=1e-11)
    # ... and where both states are one, the derivative.
    pull = traction_gradient(found, old, old, vector)
    ahead, behind = (evaluated(found, states[0] + sign * 1e-6 * direction) for sign in (1, -1))
    slope = np.sum(vector * (ahead.traction - behind.traction)) / 2e-6
    assert np.sum(pull * direction) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize(
    ("dimension", "cell", "degree"), [(2, "triangle", 2), (3, "hexahedron", 2)]
)
def test_nodes_are_merged_face_by_face(dimension, cell, degree):
    found = surface(dimension, cell, degree, "nodes")
    counts = COUNTS[dimension]
    bottom = np.prod([degree * count + 1 for count in counts[:-1]])
    assert (found.tag == FacetTag.BOTTOM).sum() == bottom
    corner = np.array([SHAPE.width / 2, *[SHAPE.thickness / 2] * (dimension - 2), 0.0])
    there = np.linalg.norm(found.reference - corner, axis=1) < 1e-12
    assert sorted(found.tag[there].tolist()) == ([1, 2] if dimension == 2 else [1, 2, 6])
    # One node moves the point there, and no other.
    values = found.position_rows()[::dimension].toarray()[:, ::dimension]
    assert np.count_nonzero(values[there]) == there.sum()
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=1e-13)


@pytest.mark.parametrize(("cell", "part"), [("hexahedron", 1.0), ("tetrahedron", 1 / 3)])
def test_gamma_h_scales_with_cell_volume_over_facet_area(cell, part):
    # A tetrahedron on a facet has a third of facet area times height.
    found = surface(3, cell, 1, "gauss", refinement=1.0, cells=(3, 2, 5))
    heights = {FacetTag.BOTTOM: 0.5 / 5, FacetTag.RIGHT: 0.3 / 3, FacetTag.FRONT: 0.4 / 2}
    longitudinal = MATERIALS[3].lame + 2 * MATERIALS[3].shear
    for tag, height in heights.items():
        expected = 100.0 * longitudinal / (part * height)
        np.testing.assert_allclose(found.gamma_h[found.tag == tag], expected, rtol=1e-12)
