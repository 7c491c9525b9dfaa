"""Generalized-alpha with impulses outside the average: coefficients, pure numbers.

The weights `alpha_m`, `alpha_f` are those of the OLD state (Chung and Hulbert 1993). Unlike there,
beta = gamma_n/2, which makes

    v_{n+1} = 2 (u_{n+1} - u_n)/dt - v_n

hold for every rho_inf, so that the work of any force against u_{n+1} - u_n is the change of kinetic
energy it causes. The contact force c acts at t_{n+1} alone and its impulse is not carried over
(after Chen, Acary, Virlez and Bruls 2013, and Kane et al. 1999): it moves u by dt^2/2 M^-1 c and v
by dt M^-1 c. Loads do the same, with their mean over the step: the inertia forces that are carried
over would follow a jump of the load only in several steps. So do damping forces, taken at the mean
velocity of the step, du/dt with du = u_{n+1} - u_n: in the average of forces, velocities that jump
would give energy back.

Steps after a change of contact are damped: what such a change shakes and the step cannot resolve is
vibration that has no meaning, and rho_inf = 0 takes it out within few steps (the idea of Rannacher
1984, who begins with strongly damped steps where data are not smooth). Motion that the step does
resolve keeps its second order. The energy that the scheme stores besides, r.K^-1 r/4 with
r = p + F, is the same for every rho_inf, which may therefore change from step to step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple


@dataclass(frozen=True)
class GeneralizedAlpha:
    """Coefficients of the scheme, all from `rho_inf` in [0, 1], each computed once.

    With beta = gamma_n/2 the spectral radius at infinite frequency is 1 for every `rho_inf`: it
    sets the damping of the middle frequencies only.
    """

    rho_inf: float
    """Spectral radius that the weights come from."""
    damped_time: float = 0.0
    """Time for which steps are taken with rho_inf = 0 after a change of contact, s."""

    @cached_property
    def damped(self) -> GeneralizedAlpha:
        """The scheme of steps after a change of contact; this one where nothing is damped."""
        return self if self.rho_inf in (0, 1) else replace(self, rho_inf=0.0)

    @cached_property
    def alpha_m(self) -> float:
        """Weight of the old acceleration."""
        return (2 * self.rho_inf - 1) / (self.rho_inf + 1)

    @cached_property
    def alpha_f(self) -> float:
        """Weight of the old forces."""
        return self.rho_inf / (self.rho_inf + 1)

    @cached_property
    def gamma(self) -> float:
        """Newmark's gamma_n = 1/2 + alpha_f - alpha_m."""
        return 0.5 + self.alpha_f - self.alpha_m

    @cached_property
    def beta(self) -> float:
        """Newmark's beta = gamma_n/2."""
        return self.gamma / 2

    @cached_property
    def contact_weight(self) -> float:
        """w_c = (1 - alpha_m)/(2 beta): what a contact force at t_{n+1} counts in the balance."""
        return (1 - self.alpha_m) / (2 * self.beta)

    @cached_property
    def skew(self) -> float:
        """1/2 - alpha_f: a step's numerical dissipation is `skew` du.dr (du, dr: increments)."""
        return 0.5 - self.alpha_f

    def weights(
        self,
        dt: float,
        mass_damping: float = 0.0,
        stiffness_damping: float = 0.0,
        spring_damping: float = 0.0,
    ) -> TangentWeights:
        """The weights of mass, stiffness and interface in the tangent of a step of length `dt`, s.

        With Rayleigh's lambda_R (1/s) and beta_R (s), and dashpot over spring (s) of what stands on
        springs.
        """
        rate = self.contact_weight / dt
        return TangentWeights(
            mass=(1 - self.alpha_m) / (self.beta * dt**2) + rate * mass_damping,
            stiffness=1 - self.alpha_f + rate * stiffness_damping,
            interface=1 - self.alpha_f,
            contact=self.contact_weight,
            spring=1 - self.alpha_f + rate * spring_damping,
        )


class TangentWeights(NamedTuple):
    """Factors of M, K, theta term of Nitsche's method, contact forces and springs in a tangent."""

    mass: float
    stiffness: float
    interface: float
    contact: float
    spring: float = 0.0
