"""Every smooth term of the equations against finite differences of what it is the derivative of."""

from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import pytest

from benchmarks.verification.fixed_pair import faces_on
from geometry.block import Block
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody
from solver.bodies.elastic_forms import StrainWeights
from solver.contact.carriers import Plane
from solver.contact.interface import Interface
from solver.contact.kinematics import ForceWeights
from solver.scene import DampingSpec, FrictionSpec
from solver.scene.material import Material
from solver.stepping.system import ports_of
from tests.surfaces import evaluated

pytestmark = pytest.mark.serial

SHAPE = Block(width=0.25, height=1.0, thickness=0.75, density=2000.0)
FACES = frozenset({FacetTag.BOTTOM, FacetTag.RIGHT, FacetTag.LEFT})
CASES = [
    pytest.param((cell, degree, plane), id=f"{cell}-{degree}-{plane}")
    for cell in ("quadrilateral", "triangle")
    for degree in (1, 2)
    for plane in ("strain", "stress")
]


@dataclass
class Thing:
    """A small body with contact points on three faces; displacements with rotation and strain."""

    body: ElasticBody
    interface: Interface

    def displacement(self, seed: int, angle: float, strain: float = 0.05) -> np.ndarray:
        """A rotation about the centre and a rough field on top of it."""
        rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        turned = self.body.arm @ rotation.T - self.body.arm
        return turned.ravel() + self.direction(seed, strain)

    def direction(self, seed: int, strain: float = 1.0) -> np.ndarray:
        size = strain * SHAPE.width / 4
        return size * np.random.default_rng(seed).uniform(-1, 1, self.body.size)

    def layer(self, u: np.ndarray) -> np.ndarray:
        return self.interface.points.points.layer.gather(u.reshape(-1, 2))

    def surface(self, u: np.ndarray):
        return evaluated(self.interface.points.points, self.layer(u))

    def work(self, nodal: np.ndarray, u: np.ndarray) -> float:
        """Of forces on the layer's nodes."""
        return float(np.sum(nodal * self.layer(u)))


@pytest.fixture(scope="module", params=CASES)
def thing(request) -> Thing:
    cell, degree, plane = request.param
    made = block_mesh(SHAPE, cells=(2, 3), cell=cell, refinement=1.5, comm=MPI.COMM_SELF)
    material = Material(young=3.0, poisson=0.25, density=2000.0, plane=plane)
    damping = DampingSpec(mass=0.0, stiffness=1e-3)
    body = ElasticBody(made.mesh, material, degree=degree, damping=damping)
    law = FrictionSpec(static=0.5)
    return Thing(body, faces_on(body, made.facet_tags, Plane.level(2), law, faces=FACES))


def slope(function, step: float = 1e-4) -> np.ndarray:
    """Derivative at 0 by differences of fourth order."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def strain_energy(thing: Thing, u: np.ndarray) -> float:
    return thing.body.strain_energy(u)


def test_internal_force_is_the_derivative_of_the_strain_energy(thing):
    body = thing.body
    body.begin(np.zeros(body.size), StrainWeights(1.0, 0.0))
    for seed in range(3):
        u, v = thing.displacement(seed, 0.4), thing.direction(10 + seed)
        work = body.internal_force(u, static=True) @ v
        assert work == pytest.approx(slope(lambda s: strain_energy(thing, u + s * v)), rel=1e-7)


def test_strain_energy_of_a_rotation_is_zero(thing):
    whole = strain_energy(thing, thing.displacement(0, 0.4))
    assert strain_energy(thing, thing.displacement(0, 2.0, strain=0.0)) < 1e-25 * whole + 1e-28


def test_averaged_internal_force_works_exactly(thing):
    """F.(u_1 - u_0) with equal weights is the difference of strain energies (Simo and Tarnow)."""
    body = thing.body
    old, new = thing.displacement(1, 0.2), thing.displacement(2, 0.9)
    body.begin(np.zeros(body.size), StrainWeights(1.0, 0.0))
    change = strain_energy(thing, new) - strain_energy(thing, old)
    body.begin(old, StrainWeights(0.5, 0.5))
    assert body.internal_force(new) @ (new - old) == pytest.approx(change, rel=1e-11)


def stiffness_times(body: ElasticBody, v: np.ndarray) -> np.ndarray:
    x, y = body.stiffness_matrix.createVecs()
    x.array[:] = v
    body.stiffness_matrix.mult(x, y)
    return y.array.copy()


def test_stiffness_is_the_derivative_of_the_internal_force_at_rest(thing):
    body = thing.body
    body.begin(np.zeros(body.size), StrainWeights(1.0, 0.0))
    v = thing.direction(3)
    expected = slope(lambda s: body.internal_force(s * v, static=True))
    found = stiffness_times(body, v)
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_stiffness_of_a_strained_body_is_the_derivative_there(thing):
    """Turned back with the body; of the undeformed one it is that at rest again."""
    body = thing.body
    body.begin(np.zeros(body.size), StrainWeights(1.0, 0.0))
    v, u = thing.direction(3), thing.displacement(6, 0.7)
    before, rotation = stiffness_times(body, v), body.rotation(u)
    turned = (v.reshape(-1, 2) @ rotation.T).ravel()
    expected = slope(lambda s: body.internal_force(u + s * turned, static=True))
    expected = (expected.reshape(-1, 2) @ rotation).ravel()
    body.restiffen(u)
    found = stiffness_times(body, v)
    body.restiffen(np.zeros(body.size))
    assert np.abs(found - before).max() > 0.02 * np.abs(before).max()
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert stiffness_times(body, v) == pytest.approx(before, abs=1e-12 * np.abs(before).max())


def test_work_of_the_viscous_force(thing):
    """Over any rotation it takes beta_R int dE:C:dE/dt, and has the force of weights (1, -1)."""
    body, dt = thing.body, 0.01
    old, new = thing.displacement(4, 0.3), thing.displacement(5, 0.9)
    body.begin(old, StrainWeights(0.5, 0.5))
    viscous = body.impulsive_force(new, dt)
    loss = body.damping.stiffness * body.increment_energy(new) / dt
    assert viscous @ (new - old) == pytest.approx(loss, rel=1e-11)
    body.begin(old, StrainWeights(1.0, -1.0))
    expected = body.damping.stiffness / dt * body.internal_force(new)
    assert viscous == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_rows_of_ports_are_those_of_the_augmented_position(thing):
    interface, points = thing.interface, thing.interface.points.points
    v = thing.layer(thing.direction(11)).ravel()
    found, moved = points.traction_rows() @ v, points.position_rows() @ v
    softened = moved - found / np.repeat(points.gamma_h, 2)
    ports = ports_of(interface.points, interface, tractions=True)
    for rows in (ports.read_rows, ports.force_rows):  # theta = 1: the same
        assert rows @ v == pytest.approx(softened)


@pytest.mark.parametrize("theta", [1, -1])
def test_theta_matrix(thing, theta):
    """v.A v = theta sum w |DT[v]|^2/gamma_h, and A u the derivative of the theta term."""
    law = FrictionSpec(static=0.5)
    interface = Interface(thing.interface.points, Plane.level(2), law, theta=theta)
    points, body = interface.points.points, thing.body
    matrix = interface.theta_matrix(body.stiffness_matrix)
    v = thing.direction(12)
    x, y = matrix.createVecs()
    x.array[:] = v
    matrix.mult(x, y)
    change = slope(lambda s: thing.surface(s * v).traction)
    weight = points.weight / points.gamma_h
    expected = theta * float(np.sum(weight[:, None] * change**2))
    assert y.array @ v == pytest.approx(expected, rel=1e-8)

    def term(s: float) -> np.ndarray:
        """int (theta/gamma_h) T.DT[w] as nodal forces, added up over the body's unknowns."""
        surface = thing.surface(s * v)
        nothing = np.zeros((points.count, 2))
        frame = interface.carrier.reference_frame
        pull = interface.traction_pull(nothing, frame, ForceWeights.of(1.0, 1.0, 1.0))
        total = np.zeros(body.size)
        interface.points.add_forces(total, surface, surface, nothing, pull)
        return total

    assert y.array == pytest.approx(slope(term), abs=1e-9 * np.abs(y.array).max())


def test_forces_of_contact_do_the_work_of_the_augmented_position(thing):
    """G^T f between two states works f.(y_1 - y_0), y = x - T/gamma_h (theta = 1)."""
    interface, points = thing.interface, thing.interface.points.points
    u0, u1 = thing.displacement(13, 0.1, 1e-2), thing.displacement(14, 0.15, 1e-2)
    old, new = thing.surface(u0), thing.surface(u1)
    force = np.random.default_rng(15).standard_normal((points.count, 2))
    frame = interface.carrier.reference_frame
    pull = interface.traction_pull(force, frame, ForceWeights.of(1.0, 0.0, 1.0))
    ends = [interface.over(surface, None, frame) for surface in (old, new)]
    vectors, reaction = interface.point_forces(*ends, force)
    total = np.zeros(thing.body.size)
    interface.points.add_forces(total, old, new, vectors, pull)
    y_old, y_new = (end.augmented for end in ends)
    assert reaction is None
    assert total @ (u1 - u0) == pytest.approx(float(np.sum(force * (y_new - y_old))), rel=1e-11)
