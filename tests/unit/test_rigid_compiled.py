"""Compiled code: the same interpreted, kept by the version of its sources, never needed."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from solver.law import compiled as module
from solver.law.compiled import borrowed, compiled
from solver.rigid.plane.model import PlaneMemory, new_memory

REPOSITORY = Path(__file__).resolve().parents[2]

RUN = """
import sys
from solver.law.compiled import NUMBA
from solver.rigid.plane.system import PlaneSystem
from solver.scene import parse_scene
block = {"width": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid", "tilt_deg": 3.0}
scene = parse_scene({"block": [block], "time": {"end": 1.0, "step": 1e-3}})
system = PlaneSystem.from_scene(scene)
rows = system.advance(250, 1e-3).rows
forbidden = {"dolfinx", "mpi4py", "petsc4py", "gmsh", "ufl"} & set(sys.modules)
print(NUMBA is not None, sorted(forbidden), *map(repr, rows[-1].tolist()))
"""


def in_a_process(**environment: str) -> tuple[bool, str, np.ndarray]:
    """Whether numba was used, forbidden imports, and the last row of a run over an impact."""
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        env=os.environ | environment,
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=True,
    )
    used, forbidden, *row = done.stdout.split()
    return used == "True", forbidden, np.array(row, dtype=np.float64)


def test_interpreted_it_gives_the_same_and_needs_no_finite_elements() -> None:
    """Both over an impact, up to round-off; neither imports what meshed bodies need."""
    used, forbidden, row = in_a_process(ROCKSLIP_NO_NUMBA="1")
    assert not used and forbidden == "[]"
    again, forbidden, machine = in_a_process()
    assert again == (module.NUMBA is not None) and forbidden == "[]"
    assert machine == pytest.approx(row, rel=1e-9, abs=1e-9)


def test_functions_stay_what_they_are_without_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    """The decorator gives the function back."""
    monkeypatch.setattr(module, "NUMBA", None)

    def double(x: float) -> float:
        """Twice x."""
        return 2 * x

    assert compiled(double) is double


@pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")
def test_nothing_is_kept_where_nothing_can_be_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A cache folder that is a file: the function is compiled all the same."""
    (tmp_path / "rockslip").write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def triple(x: float) -> float:
        """Three times x."""
        return 3 * x

    assert compiled(triple)(2.0) == 6.0


def test_code_is_kept_by_the_version_of_its_sources(tmp_path: Path) -> None:
    """A change of any file, also of one of constants, and in a folder below, is another version."""
    (tmp_path / "steps.py").write_text("def step(x):\n    return x\n")
    (tmp_path / "plane").mkdir()
    constants = tmp_path / "plane" / "constants.py"
    constants.write_text("LIMIT = 1.0\n")
    before = module.digest([tmp_path])
    assert module.digest([tmp_path]) == before
    constants.write_text("LIMIT = 2.0\n")
    assert module.digest([tmp_path]) != before


def test_borrowed_arrays_are_the_same_arrays() -> None:
    """What is written through them is seen outside."""

    @compiled
    def write(memory: module.Arrays) -> None:
        """Write one number."""
        borrowed(memory).gap[1] = 7.0  # type: ignore[attr-defined]

    memory = new_memory(3)
    write(memory)
    assert memory.gap.tolist() == [0.0, 7.0, 0.0]


class Nested(NamedTuple):
    """A tuple of arrays in another."""

    inner: PlaneMemory
    numbers: np.ndarray


@compiled
def rest(arrays: Nested) -> tuple[float, np.ndarray]:
    """Write one number, return the sum of some and an array of its own."""
    own = borrowed(arrays)
    own.inner.gap[0] = 5.0
    return own.numbers[1:].sum(), 2.0 * own.numbers


def test_borrowed_arrays_outlive_their_use() -> None:
    """Also those of tuples in tuples: nobody frees what Python holds, nor keeps what it drops."""
    for k in range(200):
        arrays = Nested(new_memory(2), np.full(1000, float(k)))
        counts = [sys.getrefcount(arrays.numbers), sys.getrefcount(arrays.inner.gap)]
        total, twice = rest(arrays)
        assert total == 999.0 * k and (twice == 2.0 * k).all()
        assert arrays.inner.gap.tolist() == [5.0, 0.0] and (arrays.numbers == k).all()
        assert [sys.getrefcount(arrays.numbers), sys.getrefcount(arrays.inner.gap)] == counts


@pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")
def test_numba_is_one_that_borrowing_is_known_to_work_with() -> None:
    """`borrowed` reaches into its internals: the versions that pyproject.toml allows."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    (wanted,) = (each for each in project["dependencies"] if each.startswith("numba"))
    least, beyond = wanted.removeprefix("numba>=").split(",<")
    numba = pytest.importorskip("numba")
    version = [int(part) for part in numba.__version__.split(".")[:2]]
    low, high = ([int(part) for part in each.split(".")] for each in (least, beyond))
    assert low <= version < high


@pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")
def test_what_was_compiled_is_known_to_be_kept(tmp_path: Path) -> None:
    """Not before a function of the module was called, though its folder is there by then."""
    script = """
import numpy as np
from solver.law import newton
from solver.law.compiled import is_kept
name = newton.__name__
before = is_kept(name)
newton.lengths(2, np.eye(2), True)
print(before, is_kept(name), is_kept("solver.rigid.plane.rows"))
"""
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["False", "True", "False"]
