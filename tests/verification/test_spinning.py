"""Blocks that spin in the air, without gravity: momentum, energy and angle are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rockslip import Result, parse_scene, simulate

pytest.importorskip("dolfinx")

SPIN = 5.0


def thrown(
    dt: float, rho_inf: float, *, young: float = 5e10, spin: object = SPIN, dimension: int = 2
) -> Result:
    """The paper's block, thrown upwards and turning, for half a second."""
    tables = {
        "dimension": dimension,
        "gravity": 0.0,
        "block": [
            {
                "width": 0.25,
                "height": 1.0,
                "thickness": 0.75,
                "mass": 503.0,
                "young": young,
                "poisson": 0.2,
                "cells": [1, 2, 3][3 - dimension :],
                "velocity": [0.0] * (dimension - 1) + [10.0],
                "angular_velocity": spin,
            }
        ],
        "damping": {"stiffness": 0.0},
        "time": {"end": 0.5, "step": dt, "rho_inf": rho_inf},
        "output": {"fields": "none"},
    }
    result = simulate(parse_scene(tables))
    assert result.status == "completed"
    return result


@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 0.8, 1.0])
def test_the_spin_stays_and_the_angle_is_of_second_order(rho_inf: float) -> None:
    """A step turns by 2 arctan(w dt/2), as the trapezoidal rule does, and loses nothing.

    Inertia forces of both ends weighed in space would have a torque of first order in dt: 3e-3 rad
    and 4e-3 of the energy at rho_inf 0.8 and 2 ms.
    """
    errors = []
    for dt in (4e-3, 2e-3):
        run = thrown(dt, rho_inf)
        spins = run.history["block.angular_velocity_rad_s"]
        assert spins == pytest.approx(SPIN, rel=2e-4 * (dt / 4e-3) ** 2)
        assert run.summary["energy"]["largest_gain_fraction"] < 1e-12
        assert run.summary["cost"]["rejected_steps"] == 0
        errors.append(run.history["block.angle_rad"][-1] - SPIN * 0.5)
        rule = 0.5 / dt * 2 * np.arctan(SPIN * dt / 2) - SPIN * 0.5
        assert errors[-1] == pytest.approx(rule, rel=0.2)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("young", [1e9, 1e13])
def test_stiff_bodies_that_turn_in_long_steps_need_no_more_iterations(young: float) -> None:
    """Turns of 0.1 rad a step, in which sound crosses up to 4000 cells."""
    cost = thrown(2e-2, 0.8, young=young).summary["cost"]
    assert cost["rejected_steps"] == 0
    assert cost["newton_iterations"] < 5 * cost["steps"]


def test_angular_momentum_about_no_axis_of_its_own_stays() -> None:
    """A block that tumbles: the spin changes, the angular momentum in space does not."""
    for dt, limit in ((4e-3, 2e-5), (2e-3, 5e-6)):
        run = thrown(dt, 0.8, spin=[2.0, 1.0, 4.0], dimension=3)
        angles, spins = (
            np.array([run.history[f"block.{name}_{axis}_{unit}"] for axis in "xyz"]).T
            for name, unit in (("angle", "rad"), ("angular_velocity", "rad_s"))
        )
        inertia = np.diag([0.75**2 + 1, 0.25**2 + 1, 0.25**2 + 0.75**2])
        turned = Rotation.from_rotvec(angles).as_matrix()
        momentum = np.einsum("nij,jk,nlk,nl->ni", turned, inertia, turned, spins)
        assert np.abs(spins - spins[0]).max() > 0.5
        assert momentum == pytest.approx(np.tile(momentum[0], (len(momentum), 1)), abs=limit)
        assert run.summary["energy"]["largest_gain_fraction"] < 1e-12
