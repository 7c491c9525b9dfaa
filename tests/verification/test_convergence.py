"""Orders of convergence: of the static block in the cell size, of its vibration in the step."""

from collections.abc import Sequence
from dataclasses import dataclass

from mpi4py import MPI

import numpy as np
import pytest
import scipy.linalg
import ufl
from dolfinx import fem

from benchmarks.verification.fixed_pair import FixedPair, faces_on
from geometry.block import Block
from geometry.mesh import block_mesh
from geometry.tags import FacetTag
from solver.bodies.elastic_body import ElasticBody, Support
from solver.bodies.elastic_forms import StrainWeights
from solver.contact.carriers import Plane
from solver.scene import DampingSpec, FrictionSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha, TangentWeights
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

pytestmark = pytest.mark.serial

SHAPE = Block(width=0.5, height=1.0, thickness=1.0, density=2000.0)
STATIC = TangentWeights(mass=0.0, stiffness=1.0, interface=0.0, contact=0.0)


def block(
    cells: tuple[int, int],
    cell: str,
    degree: int,
    plane: str = "strain",
    held=False,
    damping=None,
):
    made = block_mesh(SHAPE, cells=cells, cell=cell, refinement=1.0, comm=MPI.COMM_SELF)
    material = Material(young=5e9, poisson=0.2, density=SHAPE.density, plane=plane)
    bottom = Support(facets=made.facet_tags.find(FacetTag.BOTTOM), directions=(0, 1))
    supports = [bottom] if held else []
    body = ElasticBody(made.mesh, material, degree=degree, damping=damping, supports=supports)
    return made, material, body


def static_error(count: int, cell: str, degree: int, plane: str) -> float:
    """Relative L2 error of a block held at its whole bottom, against a smooth field made up.

    The loads that belong to the field, in the volume and on the boundary, are derived from it by
    differentiation, apart from the body's own forms. Its amplitude is so small that the nonlinear
    internal force at the solution balances them as well.
    """
    made, material, body = block((count, 2 * count), cell, degree, plane, held=True)
    x, y = ufl.SpatialCoordinate(made.mesh)
    amplitude = 1e-8
    exact = amplitude * ufl.as_vector([y * ufl.sin(3 * x + 2 * y), y * ufl.cos(4 * x) * ufl.exp(y)])
    strain = ufl.sym(ufl.grad(exact))
    stress = material.lame * ufl.tr(strain) * ufl.Identity(2) + 2 * material.shear * strain
    test, normal = ufl.TestFunction(body.space), ufl.FacetNormal(made.mesh)
    finely = {"quadrature_degree": 2 * degree + 4}
    dx, ds = ufl.dx(metadata=finely), ufl.ds(metadata=finely)
    loads = ufl.inner(-ufl.div(stress), test) * dx + ufl.inner(stress * normal, test) * ds
    right = fem.assemble_vector(fem.form(loads)).array[: body.size].copy()
    right[body.fixed] = 0.0
    solution = fem.Function(body.space)
    solution.x.array[: body.size] = body.factorization(STATIC).solve(right)
    nothing = np.zeros(body.size)
    body.begin(nothing, StrainWeights(1.0, 0.0))
    residual = body.internal_force(solution.x.array, static=True) - right
    residual[body.fixed] = 0.0
    assert np.abs(residual).max() < 1e-6 * np.abs(right).max()
    squares = (ufl.inner(w, w) * dx for w in (solution - exact, exact))
    error, size = (fem.assemble_scalar(fem.form(square)) for square in squares)
    return float(np.sqrt(error / size))


@pytest.mark.parametrize(
    ("cell", "degree", "plane"),
    [
        ("quadrilateral", 1, "strain"),
        ("quadrilateral", 2, "stress"),
        ("triangle", 1, "stress"),
        ("triangle", 2, "strain"),
    ],
)
def test_static_block_converges_in_the_cell_size(cell, degree, plane):
    counts = (8, 16, 32) if degree == 1 else (4, 8, 16)
    errors = [static_error(count, cell, degree, plane) for count in counts]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(degree + 1, abs=0.15)
    assert orders[-1] == pytest.approx(degree + 1, abs=0.08)
    assert errors[-1] < (1e-3 if degree == 1 else 5e-5)


@dataclass
class Vibration:
    """A free block in the air, its stepper, and its lowest vibration."""

    body: ElasticBody
    stepper: Stepper
    shape: np.ndarray
    frequency: float

    def start(self, amplitude: float, speed: float = 0.0):
        """Deflected and moving as the mode, 20 mm above the ground."""
        up = np.zeros_like(self.body.nodes)
        up[:, 1] = 0.02
        self.aloft = up.ravel()
        u = self.aloft + amplitude * self.shape
        return self.stepper.start(u, speed * self.shape)

    def coordinate(self, state) -> float:
        """Modal coordinate of a state."""
        return float(self.shape @ self.body.inertia(state.u - self.aloft))

    def energy(self, state) -> float:
        return state.kinetic + state.strain + self.stepper.interface_energy(state)


def dense(matrix) -> np.ndarray:
    start, columns, values = matrix.getValuesCSR()
    full = np.zeros(matrix.getSize())
    for row in range(len(full)):
        part = slice(start[row], start[row + 1])
        full[row, columns[part]] = values[part]
    return full


def vibration(rho_inf: float, theta: int, damping: DampingSpec | None = None) -> Vibration:
    made, _, body = block((2, 4), "quadrilateral", 2, damping=damping)
    law = FrictionSpec(static=0.5)
    contact = FixedPair(faces_on(body, made.facet_tags, Plane.level(2), law, theta=theta))
    stepper = Stepper(System([body]), [contact], GeneralizedAlpha(rho_inf), gravity=np.zeros(2))
    stepper.start(np.zeros(body.size), np.zeros(body.size))  # faces join
    stiffness = dense(body.stiffness_matrix)
    if theta:
        stiffness -= dense(stepper.links[0].interface.theta_matrix(body.mass_matrix))
    squares, shapes = scipy.linalg.eigh(stiffness, dense(body.mass_matrix))
    assert np.abs(squares[:3]).max() < 1e-6 * squares[3]  # three rigid motions
    return Vibration(body, stepper, shapes[:, 3], float(np.sqrt(squares[3])))


def largest_error(vibrating: Vibration, damping: DampingSpec | None, dts: Sequence[float]) -> float:
    """Over a run, relative to the start, against the damped oscillation in closed form.

    q'' + (lambda + beta omega^2) q' + omega^2 q = 0, q(0) = 1, q'(0) = omega.
    """
    omega, given = vibrating.frequency, damping or DampingSpec()
    decay = (given.mass + given.stiffness * omega**2) / 2
    damped = np.sqrt(omega**2 - decay**2)
    amplitude = 1e-7
    state, worst = vibrating.start(amplitude, amplitude * omega), 0.0
    sine = (decay + omega) / damped
    for dt in dts:
        state, _ = vibrating.stepper.advance(state, dt)
        turned = damped * state.time
        exact = np.exp(-decay * state.time) * (np.cos(turned) + sine * np.sin(turned))
        worst = max(worst, abs(vibrating.coordinate(state) / amplitude - exact))
    assert not state.contacts[0].force.any()
    return worst


@pytest.mark.parametrize(
    ("rho_inf", "theta", "damped"),
    [(0.0, 0, True), (0.5, 1, True), (0.8, 0, False), (0.8, 1, True), (1.0, 1, False)],
)
def test_vibration_converges_in_the_step(rho_inf, theta, damped):
    """Order 2, with both parts of Rayleigh damping at 2 % each.

    The viscous stress is no part of Nitsche's traction, so that with theta = 1 the damping is not
    exactly modal: there it is left to mass-proportional damping alone.
    """
    omega = vibration(rho_inf, theta).frequency
    part = 0.04
    damping = (
        DampingSpec(mass=part * omega, stiffness=0.0 if theta else part / omega) if damped else None
    )
    vibrating = vibration(rho_inf, theta, damping)
    period = 2 * np.pi / omega
    errors = [largest_error(vibrating, damping, [period / n] * (3 * n // 2)) for n in (40, 80, 160)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(2.0, abs=0.15)
    assert errors[-1] < 0.01


@pytest.mark.parametrize("theta", [0, 1])
def test_start_is_in_balance(theta):
    """p_0 = -K u_0, from the matrices; small displacements, loads from nowhere, no damping in p."""
    damping = DampingSpec(mass=30.0, stiffness=2e-4)
    vibrating = vibration(0.8, theta, damping)
    body = vibrating.body
    u, v = 1e-9 * np.random.default_rng(0).uniform(-1, 1, (2, body.size))
    v *= vibrating.frequency
    state = vibrating.stepper.start(u, v)
    interface = vibrating.stepper.links[0].interface
    mass, stiffness = dense(body.mass_matrix), dense(body.stiffness_matrix)
    elastic = stiffness @ u
    if theta:
        elastic -= dense(interface.theta_matrix(body.mass_matrix)) @ u
    assert state.p == pytest.approx(-elastic, abs=1e-6 * np.abs(elastic).max())
    assert state.kinetic == pytest.approx(v @ mass @ v / 2, rel=1e-9)
    assert state.strain == pytest.approx(u @ stiffness @ u / 2, rel=1e-6)


@pytest.mark.parametrize("theta", [0, 1])
def test_energy_is_kept_with_changing_steps(theta):
    """Undamped at rho_inf = 1; the amplitude is large, so that strains are not linear."""
    vibrating = vibration(1.0, theta)
    mode = vibrating.shape.reshape(-1, 2)
    state = vibrating.start(1e-3 * SHAPE.width / np.abs(mode).max())
    period = 2 * np.pi / vibrating.frequency
    start, kinetic, worst = vibrating.energy(state), 0.0, 0.0
    for dt in np.tile([1, 1, 0.5, 0.25, 0.25, 0.5, 1, 0.125], 15) * period / 20:
        state, exchange = vibrating.stepper.advance(state, dt)
        worst = max(worst, abs(vibrating.energy(state) / start - 1))
        kinetic = max(kinetic, state.kinetic)
        assert exchange.damping == exchange.contact == exchange.friction == 0.0
        assert abs(exchange.numerical) < 1e-10 * start  # no more than the solver's tolerance
    assert kinetic > 0.9 * start
    assert worst < 1e-10
