"""Compiled code: kept by the version of all sources; linked late."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from solver.law import compiled as module
from solver.law import late_linking
from solver.law.compiled import compiled, digest

REPOSITORY = Path(__file__).resolve().parents[2]

needs_numba = pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")


def output_of(script: str, folder: Path = REPOSITORY, **environment: str) -> str:
    """Output of a script in a process of its own, in a folder."""
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"PYTHONPATH": str(folder)} | environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


KERNELS = {
    "solver/__init__.py": "",
    "solver/contact/__init__.py": "",
    "solver/contact/inner.py": "from solver.law.compiled import compiled\nFACTOR = 2.0\n"
    "@compiled\ndef inner(x):\n    return FACTOR * x\n",
    "solver/contact/outer.py": "from solver.law.compiled import compiled\n"
    "from solver.contact.inner import inner\n"
    "@compiled\ndef outer(x):\n    return inner(x) + 1.0\n",
}
WATCHED = """
from solver.contact.outer import outer
from solver.law.compiled import watching
class Said:
    def pause(self, why): print(repr(why))
    def go_on(self, seconds): print("done")
with watching(Said()):
    outer(1.0)
    outer(2.0)
print(outer(1.0))
"""


@pytest.mark.slow
@needs_numba
def test_machine_code_is_kept_until_any_source_below_changes(tmp_path: Path) -> None:
    """A change of a constant that a function below holds, whose caller's file stays as it is."""
    for name, text in KERNELS.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    shutil.copytree(REPOSITORY / "solver" / "law", tmp_path / "solver" / "law")
    (tmp_path / "geometry").mkdir()

    def said(cache: str) -> list[str]:
        return output_of(WATCHED, tmp_path, NUMBA_CACHE_DIR=str(tmp_path / cache)).splitlines()

    compiles, reads = ["''", repr(module.COMPILING), "done"], ["''", "done"]
    assert said("cache") == [*compiles, "3.0"]
    assert said("cache") == [*reads, "3.0"]
    inner = tmp_path / "solver/contact/inner.py"
    inner.write_text(KERNELS["solver/contact/inner.py"].replace("2.0", "5.0"))
    assert said("cache") == [*compiles, "6.0"]
    assert len(list((tmp_path / "cache" / "rockslip" / "compiled").iterdir())) == 2
    (tmp_path / "file").write_text("")
    assert said("file") == ["''", repr(module.COMPILING_IN_VAIN), "done", "6.0"]


def test_the_version_is_that_of_all_that_a_package_may_import_from(tmp_path: Path) -> None:
    """In the order in which docs/architecture.md lets packages import from one another."""
    order = run_path(str(REPOSITORY / "docs" / "draw_architecture.py"))["ORDER"]
    assert list(order)[1 : len(module.PACKAGES) + 1] == list(module.PACKAGES)
    below = module.sources_below("contact")
    solver = REPOSITORY / "solver"
    assert {REPOSITORY / "geometry", solver / "types.py", solver / "law"} <= set(below)
    assert solver / "contact" in below and solver / "stepping" not in below
    for name in ("types.py", "rigid/system.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("LIMIT = 1.0\n")
        before = digest([tmp_path])
        (tmp_path / name).write_text("LIMIT = 2.0\n")
        assert digest([tmp_path]) != before


def test_code_of_versions_that_nothing_has_used_for_a_month_is_removed(tmp_path: Path) -> None:
    """They are removed when code of a new version is made."""
    month = time.time() - 1.01 * module.UNUSED
    for name in ("unused", "recent"):
        (tmp_path / name).mkdir()
    os.utime(tmp_path / "unused", (month, month))
    own = module._folder_of_version(tmp_path, "law")
    assert own is not None
    assert {folder.name for folder in tmp_path.iterdir()} == {"recent", own.name}


@compiled
def _inverse(matrix: np.ndarray) -> np.ndarray:
    """An inverse; an error where there is none."""
    if matrix[0, 0] < 0.0:
        raise ValueError("negative")
    return np.linalg.inv(matrix)


@compiled
def _size(matrix: np.ndarray) -> float:
    """Norm of an inverse; -1 where there is none or the matrix is refused."""
    try:
        return float(np.linalg.norm(_inverse(matrix)))
    except Exception:
        return -1.0


@compiled
def _sizes(matrix: np.ndarray, count: int) -> float:
    """Sum of some of them, by two ways."""
    total = 0.0
    for k in range(count):
        total += _size(matrix * (k + 1.0)) + _inverse(matrix)[0, 0]
    return total


@pytest.mark.slow
@needs_numba
def test_functions_linked_late_do_what_they_do_alone() -> None:
    """Their errors, too; called by one another, from Python, and by functions of others."""
    numba = pytest.importorskip("numba")
    matrix = np.array([[2.0, 1.0], [1.0, 3.0]])
    expected = sum(np.linalg.norm(np.linalg.inv((k + 1) * matrix)) + 0.6 for k in range(3))
    assert _sizes(matrix, 3) == pytest.approx(expected, rel=1e-14)
    assert _size(np.zeros((2, 2))) == _size(-matrix) == -1.0
    assert _inverse(matrix) == pytest.approx(np.linalg.inv(matrix), rel=1e-14)
    with pytest.raises(ValueError, match="negative"):
        _inverse(-matrix)

    @numba.njit
    def foreign(matrix: np.ndarray) -> float:
        """A function of someone else that needs what was linked late before."""
        return float(np.linalg.norm(np.linalg.inv(matrix)))

    @numba.njit
    def above(matrix: np.ndarray) -> float:
        """Another that calls it."""
        return 2.0 * foreign(matrix)

    assert above(matrix) == 2.0 * foreign(matrix)
    assert foreign(matrix) == pytest.approx(np.linalg.norm(np.linalg.inv(matrix)), rel=1e-14)


@needs_numba
def test_late_linking_works_with_this_numba() -> None:
    """Else all is compiled as numba does by itself, in three to five times the time."""
    pytest.importorskip("numba")
    assert late_linking._library_class() is not None
