"""Compiler options of forms: fast, for this processor, unless the user has set others."""

from mpi4py import MPI

import numpy as np
import pytest
from dolfinx import fem, jit, mesh

from solver.bodies import packed_form
from solver.bodies.elastic_forms import ElasticForms
from solver.scene.material import Material

pytestmark = pytest.mark.serial

NAME = "cffi_extra_compile_args"


@pytest.fixture(autouse=True)
def _fresh():
    packed_form.compiler_options.cache_clear()
    yield
    packed_form.compiler_options.cache_clear()


def _force(u: np.ndarray) -> np.ndarray:
    """Internal force of a unit square of four cells at a displacement."""
    square = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    space = fem.functionspace(square, ("Lagrange", 1, (2,)))
    material = Material(young=1e9, poisson=0.2, density=2000.0)
    forms = ElasticForms(fem.Function(space), fem.Function(space), material, viscous=False)
    forms.place(u)
    force = np.empty_like(u)
    forms.force.vector(force)
    return force


def test_forces_are_those_of_the_compiler_that_dolfinx_asks_for(monkeypatch):
    """But for round-off; what is not a number stays so."""
    u = 1e-3 * np.random.default_rng(1).random(18)
    fast = _force(u)
    assert np.isnan(_force(np.full(18, np.nan))).all()
    monkeypatch.setattr(packed_form, "compiler_options", dict)
    usual = _force(u)
    assert fast == pytest.approx(usual, rel=0, abs=1e-14 * np.abs(usual).max())


def test_settings_of_the_user_stay(monkeypatch):
    monkeypatch.setattr(jit, "get_options", lambda: {NAME: ["-O1"]})
    assert packed_form.compiler_options() == {}


@pytest.mark.parametrize(
    ("flags", "level"),
    [
        (set(), None),
        (packed_form.LEVELS["x86-64-v3"], "-march=x86-64-v3"),
        (packed_form.LEVELS["x86-64-v4"], None),  # no processor has these alone
        (packed_form.LEVELS["x86-64-v3"] | packed_form.LEVELS["x86-64-v4"], "-march=x86-64-v4"),
    ],
)
def test_the_largest_instruction_set_of_the_processor_is_named(monkeypatch, tmp_path, flags, level):
    about = tmp_path / "cpuinfo"
    about.write_text(f"processor : 0\nflags : {' '.join(sorted(flags))}\n", encoding="ascii")
    monkeypatch.setattr(packed_form, "Path", lambda _: about)
    monkeypatch.setattr(packed_form.platform, "machine", lambda: "x86_64")
    found = packed_form.compiler_options()[NAME]
    assert [option for option in found if "-march" in option] == ([level] if level else [])
