"""The elastic law against closed forms of linear elasticity."""

import numpy as np
import pytest

from solver.mechanics.material import Material

E, NU, EPS = 30e9, 0.3, 1e-4


def test_uniaxial_stress_in_plane_stress():
    """Lateral strain -nu eps: stress E eps along, none across."""
    law = Material(young=E, poisson=NU, density=1.0, plane="stress")
    stress = law.stress(np.diag([EPS, -NU * EPS]))
    assert stress == pytest.approx(np.diag([E * EPS, 0.0]), abs=1e-6)


def test_uniaxial_stress_in_plane_strain():
    """Modulus E/(1 - nu^2), lateral ratio nu/(1 - nu)."""
    law = Material(young=E, poisson=NU, density=1.0)
    stress = law.stress(np.diag([EPS, -NU / (1 - NU) * EPS]))
    assert stress == pytest.approx(np.diag([E / (1 - NU**2) * EPS, 0.0]), abs=1e-6)


def test_uniaxial_stress_in_space():
    law = Material(young=E, poisson=NU, density=1.0, plane="solid")
    stress = law.stress(EPS * np.diag([1.0, -NU, -NU]))
    assert stress == pytest.approx(np.diag([E * EPS, 0.0, 0.0]), abs=1e-6)


@pytest.mark.parametrize(
    ("plane", "modulus"),
    [
        ("strain", E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))),
        ("stress", E / (1 - NU**2)),
        ("solid", E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))),
    ],
)
def test_no_lateral_strain(plane, modulus):
    """The stiffness against a contact pressure: oedometer modulus, or that of a plate."""
    law = Material(young=E, poisson=NU, density=1.0, plane=plane)
    assert law.longitudinal == pytest.approx(modulus)
    assert law.stress(np.diag([EPS, 0.0]))[0, 0] == pytest.approx(modulus * EPS)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_shear_and_no_poisson_effect(plane):
    law = Material(young=E, poisson=NU, density=1.0, plane=plane)
    sheared = law.stress(np.array([[0.0, EPS], [EPS, 0.0]]))
    assert sheared == pytest.approx(E / (1 + NU) * np.array([[0, EPS], [EPS, 0]]))
    cork = Material(young=E, poisson=0.0, density=1.0, plane=plane)
    assert cork.stress(np.diag([EPS, 2 * EPS])) == pytest.approx(E * np.diag([EPS, 2 * EPS]))


def test_many_strains_at_once():
    """One matrix at a time or an array of them; the argument stays as it was."""
    law = Material(young=E, poisson=NU, density=1.0)
    strains = np.random.default_rng(0).standard_normal((4, 3, 2, 2))
    strains += strains.swapaxes(-1, -2)
    kept = strains.copy()
    stresses = law.stress(strains)
    assert np.array_equal(strains, kept)
    for i, j in np.ndindex(4, 3):
        assert np.array_equal(stresses[i, j], law.stress(strains[i, j]))
