"""The elastic law against closed forms of linear elasticity."""

import numpy as np
import pytest

from solver.contact.nitsche_points import normal_stress_map
from solver.scene.material import Material

E, NU, EPS = 30e9, 0.3, 1e-4


def stress_of(law: Material, strain: np.ndarray) -> np.ndarray:
    """S, column by column: what it draws at faces across the axes."""
    return (normal_stress_map(law, np.eye(len(strain))) @ (2 * strain).ravel()).T


def test_uniaxial_stress_in_plane_stress():
    """Lateral strain -nu eps: stress E eps along, none across."""
    law = Material(young=E, poisson=NU, density=1.0, plane="stress")
    stress = stress_of(law, np.diag([EPS, -NU * EPS]))
    assert stress == pytest.approx(np.diag([E * EPS, 0.0]), abs=1e-6)


def test_uniaxial_stress_in_plane_strain():
    """Modulus E/(1 - nu^2), lateral ratio nu/(1 - nu)."""
    law = Material(young=E, poisson=NU, density=1.0)
    stress = stress_of(law, np.diag([EPS, -NU / (1 - NU) * EPS]))
    assert stress == pytest.approx(np.diag([E / (1 - NU**2) * EPS, 0.0]), abs=1e-6)


def test_uniaxial_stress_in_space():
    law = Material(young=E, poisson=NU, density=1.0, plane="solid")
    stress = stress_of(law, EPS * np.diag([1.0, -NU, -NU]))
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
    assert stress_of(law, np.diag([EPS, 0.0]))[0, 0] == pytest.approx(modulus * EPS)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_shear_and_no_poisson_effect(plane):
    law = Material(young=E, poisson=NU, density=1.0, plane=plane)
    sheared = stress_of(law, np.array([[0.0, EPS], [EPS, 0.0]]))
    assert sheared == pytest.approx(E / (1 + NU) * np.array([[0, EPS], [EPS, 0]]))
    cork = Material(young=E, poisson=0.0, density=1.0, plane=plane)
    assert stress_of(cork, np.diag([EPS, 2 * EPS])) == pytest.approx(E * np.diag([EPS, 2 * EPS]))


@pytest.mark.parametrize(("plane", "d"), [("strain", 2), ("stress", 2), ("solid", 3)])
def test_slanted_normals(plane, d):
    """S N of many normals at once; rows symmetric in the strain's indices."""
    law = Material(young=E, poisson=NU, density=1.0, plane=plane)
    rng = np.random.default_rng(0)
    normals, strain = rng.standard_normal((5, d)), rng.standard_normal((d, d))
    strain += strain.T
    rows = normal_stress_map(law, normals)
    assert rows @ (2 * strain).ravel() == pytest.approx(normals @ stress_of(law, strain), rel=1e-12)
    entries = rows.reshape(5, d, d, d)
    assert np.array_equal(entries, entries.swapaxes(2, 3))
