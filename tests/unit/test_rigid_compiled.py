"""Compiled code: the same interpreted, kept by the version of its sources, never needed."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from solver.law import compiled as module
from solver.law import kept_code, late_linking, sources
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


def test_code_of_versions_that_nothing_has_used_for_a_month_is_removed(tmp_path: Path) -> None:
    """When code of a new version is made; what is used stays, however old it is."""
    month = time.time() - 1.01 * kept_code.UNUSED
    for name in ("used", "unused", "recent"):
        kept_code.folder_of(name, tmp_path).joinpath("code").write_text("")
    for name in ("used", "unused"):
        os.utime(tmp_path / name, (month, month))
    kept_code.folder_of("used", tmp_path)
    assert {folder.name for folder in tmp_path.iterdir()} == {"used", "unused", "recent"}
    kept_code.folder_of("new", tmp_path)
    assert {folder.name for folder in tmp_path.iterdir()} == {"used", "recent", "new"}


def test_versions_of_folders_are_those_of_all_files_in_them(tmp_path: Path) -> None:
    """A change of any file, also of one of constants, and in a folder below, is another version."""
    (tmp_path / "steps.py").write_text("def step(x):\n    return x\n")
    (tmp_path / "plane").mkdir()
    constants = tmp_path / "plane" / "constants.py"
    constants.write_text("LIMIT = 1.0\n")
    before = sources.digest([tmp_path])
    assert sources.digest([tmp_path]) == before
    constants.write_text("LIMIT = 2.0\n")
    assert sources.digest([tmp_path]) != before


LOADED = """
import importlib, sys
importlib.import_module(sys.argv[1])
print(*(m.__file__ for n, m in sys.modules.items() if n.split(".")[0] in ("geometry", "solver")))
"""


@pytest.mark.parametrize(
    "module_name",
    [
        *("solver.rigid.plane.rows", "solver.rigid.space.rows", "solver.law.local_problem"),
        *("solver.contact.kernels.facets", "solver.contact.kernels.nitsche"),
        "solver.bodies.kinematics",
    ],
)
def test_the_version_of_machine_code_is_that_of_all_that_is_imported(module_name: str) -> None:
    """What Python loads with a module of compiled functions is what their version follows from."""
    done = subprocess.run(
        [sys.executable, "-c", LOADED, module_name],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=True,
    )
    file = REPOSITORY / (module_name.replace(".", "/") + ".py")
    assert {Path(name) for name in done.stdout.split()} <= sources.closure(file)


def test_machine_code_outlives_changes_of_what_it_does_not_hold() -> None:
    """Blocks in the plane hold friction; nothing of blocks in space, of scenes or of elements."""
    solver = REPOSITORY / "solver"
    found = sources.closure(solver / "rigid" / "plane" / "rows.py")
    assert {solver / "law" / "friction.py", solver / "history" / "columns.py"} <= found
    others = ("rigid/space", "scene", "contact", "bodies", "reference", "run")
    assert not [file for file in found for name in others if (solver / name) in file.parents]


def test_imports_are_found_however_they_are_written() -> None:
    """Names of modules, in parentheses, renamed; not those of checkers of types or of functions."""
    text = (
        "import solver.law.impact as hit\nfrom solver.law import (  # both\n    friction as f,\n"
        "    newton,\n)\nif TYPE_CHECKING:\n    from solver.scene import Scene\n"
        "def late():\n    from solver.rigid import start\n"
    )
    names = ["solver.law.impact", "solver.law.friction", "solver.law.newton"]
    assert list(sources._modules(text)) == names


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


@compiled
def largest_of(numbers: np.ndarray) -> float:
    """The largest number; the array is written to."""
    numbers[0] = -1.0
    return float(numbers.max())


@compiled
def all_but_first(numbers: np.ndarray) -> np.ndarray:
    """A part of what is given."""
    return numbers[1:]


@pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")
def test_arrays_of_python_are_counted_only_where_a_part_of_them_may_be_given_back() -> None:
    """That part then outlives all else that knew of the array."""
    numbers, ways = np.arange(4.0), []
    names = late_linking._COUNTED, late_linking._BORROWED
    before = sys.getrefcount(numbers)
    assert largest_of(numbers) == 3.0 and numbers[0] == -1.0
    assert sys.getrefcount(numbers) == before
    rest_of_them = all_but_first(np.arange(1000.0))
    for k in range(100):  # what was freed would be written over
        np.full(1000, -float(k))
    assert (rest_of_them == np.arange(1.0, 1000.0)).all()
    for function in (largest_of, all_but_first):
        machine = function._machine  # type: ignore[attr-defined]
        machine.recompile()  # the text of code that was read back is not known
        (overload,) = machine.overloads.values()
        text = overload.library.get_llvm_str()
        ways.append([f"@{name}(" in text for name in names])
    assert ways == [[False, True], [True, False]]


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


TELLING = """
import sys
from solver.law.late_linking import watching
class Said:
    def pause(self): print("waits")
    def say(self, why): print(why)
    def go_on(self): print("done")
from solver.law.newton import lengths
import numpy as np
with watching(Said()):
    lengths(2, np.eye(2), True)
    lengths(2, np.eye(2), False)
"""


@pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")
def test_who_watches_is_told_of_what_is_compiled_or_read_back(tmp_path: Path) -> None:
    """Once for all functions below, and why; where nothing can be kept the words say so."""

    def said(folder: Path) -> list[str]:
        done = subprocess.run(
            [sys.executable, "-c", TELLING],
            env=os.environ | {"NUMBA_CACHE_DIR": str(folder)},
            cwd=REPOSITORY,
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout.splitlines()

    assert said(tmp_path / "cache") == ["waits", late_linking.COMPILING, "done"]
    assert said(tmp_path / "cache") == ["waits", "done"]
    (tmp_path / "file").write_text("")
    assert said(tmp_path / "file") == ["waits", late_linking.COMPILING_IN_VAIN, "done"]


@compiled
def _inverse(matrix: np.ndarray) -> np.ndarray:
    """An inverse; an error where there is none."""
    if matrix[0, 0] < 0.0:
        raise ValueError("negative")
    return np.linalg.inv(matrix)


@compiled
def _size(matrix: np.ndarray) -> float:
    """Norm of an inverse; -1 where there is none, -2 where the matrix is refused."""
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


@pytest.mark.skipif(module.NUMBA is None, reason="numba is not installed")
def test_functions_linked_late_do_what_they_do_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Their errors, too; called by one another, from Python, and by functions of others."""
    numba = pytest.importorskip("numba")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
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


def test_late_linking_works_with_this_numba() -> None:
    """Else all is compiled as numba does by itself, in three times the time."""
    if module.NUMBA is not None:
        assert late_linking._codegen_class() is not None
