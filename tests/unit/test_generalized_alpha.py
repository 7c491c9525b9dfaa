"""The time stepping scheme: its coefficients, its updates, and the energy identity they give."""

import numpy as np
import pytest

from solver.scheme.generalized_alpha import GeneralizedAlpha

RHO = [0.0, 0.3, 0.5, 0.8, 1.0]


@pytest.mark.parametrize(
    ("rho", "alpha_m", "alpha_f", "gamma", "beta"),
    [
        (0.0, -1, 0, 3 / 2, 3 / 4),
        (0.5, 0, 1 / 3, 5 / 6, 5 / 12),
        (0.8, 1 / 3, 4 / 9, 11 / 18, 11 / 36),
        (1.0, 1 / 2, 1 / 2, 1 / 2, 1 / 4),
    ],
)
def test_coefficients(rho, alpha_m, alpha_f, gamma, beta):
    """Chung and Hulbert's, worked out by hand, but beta = gamma/2."""
    scheme = GeneralizedAlpha(rho)
    assert scheme.alpha_m == pytest.approx(alpha_m, abs=1e-15)
    assert scheme.alpha_f == pytest.approx(alpha_f, abs=1e-15)
    assert scheme.gamma == pytest.approx(gamma)
    assert scheme.beta == pytest.approx(beta)
    assert scheme.contact_weight == pytest.approx((1 - alpha_m) / (2 * beta))
    assert scheme.skew == pytest.approx((1 - rho) / (2 * (1 + rho)))


def amplification(scheme: GeneralizedAlpha, beta: float, stiffness: float) -> np.ndarray:
    """(u, v, a) of M = 1, dt = 1 from one step to the next."""
    am, af, gamma = scheme.alpha_m, scheme.alpha_f, scheme.gamma
    new = np.array(
        [
            [1, 0, -beta],
            [0, 1, -gamma],
            [(1 - af) * stiffness, 0, 1 - am],
        ]
    )
    old = np.array([[1, 1, 0.5 - beta], [0, 1, 1 - gamma], [-af * stiffness, 0, -am]])
    return np.linalg.solve(new, old)


@pytest.mark.parametrize("rho", RHO)
def test_spectral_radius_of_stiff_vibrations(rho):
    """Chung and Hulbert's beta makes it rho_inf, which pins alphas and gamma down; here it is 1."""
    scheme = GeneralizedAlpha(rho)
    theirs = (1 - scheme.alpha_m + scheme.alpha_f) ** 2 / 4
    for beta, radius in [(theirs, rho), (scheme.beta, 1.0)]:
        # The triple eigenvalue -rho of theirs splits with the cube root of what is finite.
        eigenvalues = np.linalg.eigvals(amplification(scheme, beta, 1e14))
        assert max(abs(eigenvalues)) == pytest.approx(radius, abs=2e-4)


@pytest.mark.parametrize("rho", RHO)
def test_second_order(rho):
    scheme = GeneralizedAlpha(rho)
    assert scheme.gamma == pytest.approx(0.5 + scheme.alpha_f - scheme.alpha_m)

    def error(steps: int) -> float:
        dt = 2 * np.pi / steps
        step = amplification(scheme, scheme.beta, dt**2)
        u, *_ = np.linalg.matrix_power(step, steps) @ [1, 0, -(dt**2)]
        # The phase is of second order; the amplitude, which u(2 pi) = 1 sees, of third.
        quarter, *_ = np.linalg.matrix_power(step, steps // 4) @ [1, 0, -(dt**2)]
        return abs(u - 1) + abs(quarter)

    assert np.log2(error(200) / error(400)) == pytest.approx(2, abs=0.1)


class Linear:
    """M u'' + C u' + K u = f + contact, stepped as `Stepper` steps a body.

    With the scheme's numbers; Rayleigh damping C = lambda_R M + beta_R K.
    """

    def __init__(
        self,
        scheme: GeneralizedAlpha,
        seed: int,
        size: int = 5,
        damping: tuple[float, float] = (0.0, 0.0),
    ):
        self.scheme, rng = scheme, np.random.default_rng(seed)
        self.M, self.K = (
            m @ m.T + 0.1 * np.eye(size) for m in rng.standard_normal((2, size, size))
        )
        self.damping, self.C = damping, damping[0] * self.M + damping[1] * self.K
        self.load = rng.standard_normal(size)
        self.u, self.v = rng.standard_normal((2, size))
        self.p = -self.K @ self.u  # r_0 = 0

    @property
    def r(self) -> np.ndarray:
        return self.p + self.K @ self.u

    @property
    def energy(self) -> float:
        return 0.5 * self.v @ self.M @ self.v + 0.5 * self.u @ self.K @ self.u - self.load @ self.u

    def advance(self, dt: float, contact: np.ndarray) -> np.ndarray:
        """One step under a given contact force at its end; returns u_{n+1} - u_n."""
        scheme, weights = self.scheme, self.scheme.weights(dt, *self.damping)
        am, af, beta = scheme.alpha_m, scheme.alpha_f, scheme.beta
        tangent = weights.mass * self.M + weights.stiffness * self.K
        right = (
            weights.mass * self.M @ (self.u + dt * self.v)
            - (am - (1 - am) * (0.5 - beta) / beta) * self.p
            - af * self.K @ self.u
            + weights.contact * (contact + self.load - self.C @ self.v)
            + (weights.stiffness - weights.interface) * self.K @ (self.u + dt * self.v)
        )
        du = np.linalg.solve(tangent, right) - self.u
        impulses = contact + self.load - self.C @ du / dt
        total = self.M @ (du - dt * self.v) / (beta * dt**2) - (0.5 / beta - 1) * self.p
        self.u, self.v = self.u + du, 2 * du / dt - self.v
        self.p = total - impulses / (2 * beta)
        return du


@pytest.mark.parametrize("rho", RHO)
@pytest.mark.parametrize("pushed", [False, True])
def test_energy_identity(rho, pushed):
    """d(E + r.K^-1 r/4) = c.du - (D/4) dr.K^-1 dr, D = 3 (1-rho)/(1+rho), with changing steps.

    And the ledger's form of it: dE = c.du - skew du.dr with the same contact force.
    """
    rng = np.random.default_rng(7)
    system = Linear(GeneralizedAlpha(rho), seed=3)
    inverse = np.linalg.inv(system.K)
    drag = 3 * (1 - rho) / (1 + rho)
    for dt in [0.1, 0.1, 0.05, 0.4, 0.025, 3.0, 0.1, 0.05, 0.7]:
        contact = 10 * rng.standard_normal(5) if pushed else np.zeros(5)
        r, energy = system.r, system.energy
        du = system.advance(dt, contact)
        dr = system.r - r
        stored = system.energy + system.r @ inverse @ system.r / 4
        before = energy + r @ inverse @ r / 4
        expected = contact @ du - drag / 4 * dr @ inverse @ dr
        assert stored - before == pytest.approx(expected, abs=1e-11 * (1 + abs(before)))
        ledger = contact @ du - system.scheme.skew * du @ dr
        assert system.energy - energy == pytest.approx(ledger, abs=1e-11 * (1 + abs(before)))


def test_the_stored_energy_is_the_same_for_every_rho():
    """Steps of different rho_inf one after the other: E + r.K^-1 r/4 never rises."""
    rng = np.random.default_rng(9)
    system = Linear(GeneralizedAlpha(0.8), seed=3)
    inverse = np.linalg.inv(system.K)

    def stored() -> float:
        return system.energy + system.r @ inverse @ system.r / 4

    for _ in range(300):
        system.scheme = GeneralizedAlpha(rng.uniform())
        before, r = stored(), system.r
        system.advance(10 ** rng.uniform(-2, 0.5), np.zeros(5))
        drag, dr = 3 * (1 - system.scheme.rho_inf) / (1 + system.scheme.rho_inf), system.r - r
        expected = -drag / 4 * dr @ inverse @ dr
        assert stored() - before == pytest.approx(expected, abs=1e-11 * (1 + abs(before)))


def test_steps_after_a_change_of_contact():
    """As damped as can be, whatever rho_inf; but where nothing is to be damped they are not."""
    assert GeneralizedAlpha(0.8).damped == GeneralizedAlpha(0.0)
    assert GeneralizedAlpha(0.0).damped == GeneralizedAlpha(0.0)
    assert GeneralizedAlpha(1.0).damped == GeneralizedAlpha(1.0)
    # Three steps a period, as of the paper's block on its corner at 1e-3 s.
    eight = amplification(GeneralizedAlpha(0.0), GeneralizedAlpha(0.0).beta, 2.2**2)
    assert max(abs(np.linalg.eigvals(eight))) ** 8 < 0.06


@pytest.mark.parametrize("rho", RHO)
@pytest.mark.parametrize("stiffness", [1e-3, 10.0])
def test_energy_identity_with_damping_and_jumps(rho, stiffness):
    """Damping takes du.C du/dt besides; of a jump of v nothing comes back later."""
    rng = np.random.default_rng(5)
    system = Linear(GeneralizedAlpha(rho), seed=3, damping=(0.3, stiffness))
    inverse = np.linalg.inv(system.K)
    drag = 3 * (1 - rho) / (1 + rho)
    for dt in [0.1, 0.1, 0.05, 0.4, 0.025, 3.0, 0.1, 0.05, 0.7]:
        system.v = system.v + rng.standard_normal(5)
        r, energy = system.r, system.energy
        du = system.advance(dt, np.zeros(5))
        dr = system.r - r
        stored = system.energy + system.r @ inverse @ system.r / 4
        before = energy + r @ inverse @ r / 4
        expected = -du @ system.C @ du / dt - drag / 4 * dr @ inverse @ dr
        assert stored - before == pytest.approx(expected, abs=1e-11 * (1 + abs(before)))


@pytest.mark.parametrize("rho", RHO)
def test_velocity_update_is_that_of_the_accelerations(rho):
    """v_{n+1} = v_n + dt [(1-gamma) a_n + gamma a_{n+1}] + dt M^-1 (c + f): p without c and f."""
    system = Linear(GeneralizedAlpha(rho), seed=11, size=1)
    gamma, (mass,) = system.scheme.gamma, system.M[0]
    for dt, push in [(0.2, 0.0), (0.1, 5.0), (0.3, -2.0), (0.1, 0.0)]:
        v, a = system.v, system.p / mass
        system.advance(dt, np.array([push]))
        push += float(system.load[0])
        after = v + dt * ((1 - gamma) * a + gamma * system.p / mass) + dt * push / mass
        assert system.v == pytest.approx(after, rel=1e-12)


def test_a_contact_force_is_an_impulse():
    """It moves u by dt^2/2 M^-1 c and v by dt M^-1 c, and is not carried over."""
    for rho in RHO:
        free, pushed = (Linear(GeneralizedAlpha(rho), seed=2, size=1) for _ in range(2))
        for system in (free, pushed):
            system.K[:], system.p = 0.0, np.zeros(1)
        dt, push = 0.3, np.array([4.0])
        free.advance(dt, 0 * push)
        pushed.advance(dt, push)
        assert pushed.u - free.u == pytest.approx(dt**2 / 2 * push / free.M[0])
        assert pushed.v - free.v == pytest.approx(dt * push / free.M[0])
        assert pushed.p == pytest.approx(free.p, abs=1e-12)


def test_rayleigh_damping_in_the_weights():
    """The mean velocity of the step is du/dt; its force counts as much as that of contact."""
    scheme, dt = GeneralizedAlpha(0.8), 1e-3
    plain, damped = scheme.weights(dt, 0.0, 0.0), scheme.weights(dt, 0.7, 2e-5)
    rate = (1 - 1 / 3) / (2 * 11 / 36) / dt
    assert damped.mass - plain.mass == pytest.approx(0.7 * rate, rel=1e-9)
    assert damped.stiffness - plain.stiffness == pytest.approx(2e-5 * rate)
    assert (damped.interface, damped.contact) == (plain.interface, plain.contact)
    assert plain.mass == pytest.approx((1 - 1 / 3) / (11 / 36 * dt**2))
    assert plain.stiffness == plain.interface == pytest.approx(5 / 9)
