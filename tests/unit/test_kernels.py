"""The library of compiled kernels: where it is looked for, and how it is built.

`tests/unit/test_environment.py` has what ./in-env does, `tests/validation/test_wheel.py` the wheel.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from numpy._core import _multiarray_umath

from solver import kernels
from solver.errors import EnvironmentTrouble
from solver.kernels.library import NAME, VARIABLE, library

pytestmark = pytest.mark.serial

REPOSITORY = Path(__file__).resolve().parents[2]
KERNELS = REPOSITORY / "solver" / "kernels"
SANITIZERS = (
    *("-O1", "-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
    "-D_GLIBCXX_ASSERTIONS",
)
NEEDS_COMPILER = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")

SPACE = """
dimension = 3
time = {end = 0.3, step = 1e-3}
output = {fields = "none"}
[[block]]
name = "lower"
model = "rigid"
width = 0.4
thickness = 0.4
height = 0.3
mass = 100.0
[[block]]
name = "upper"
on = "lower"
model = "rigid"
width = 0.3
thickness = 0.3
height = 0.9
mass = 200.0
tilt_deg = 3.0
"""
"""Two blocks in space and an impact."""

BEYOND = """
import numpy as np
from solver.kernels import meshed
meshed.resultant(np.zeros(4), np.zeros(3))
"""
"""Forces on nodes in space, of which the last one has one component."""


@pytest.fixture(autouse=True)
def anew() -> Iterator[None]:
    """Each test looks for the library itself."""
    library.cache_clear()
    yield
    library.cache_clear()


def build(file: Path, *options: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [KERNELS / "build.sh", file, *options], capture_output=True, text=True, check=False
    )


def file_of(loaded: ModuleType) -> str:
    assert loaded.__file__ is not None
    return loaded.__file__


def test_it_is_loaded_once_and_shows_its_interface_alone() -> None:
    loaded = library()
    assert library() is loaded and loaded.world_new and loaded.settle
    if shutil.which("nm") is None:
        return
    names = subprocess.run(
        ["nm", "-D", "--defined-only", file_of(loaded)], capture_output=True, text=True, check=True
    ).stdout.split()[2::3]
    assert names == ["PyInit_kernels"]


def test_it_lies_in_a_folder_of_the_package(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As a wheel has it, or beside the sources of an editable installation."""
    built = Path(file_of(library()))
    library.cache_clear()
    monkeypatch.delenv(VARIABLE, raising=False)
    shutil.copy(built, tmp_path / NAME)
    for folders in ([tmp_path], [KERNELS, tmp_path]):
        monkeypatch.setattr(kernels, "__path__", [str(folder) for folder in folders])
        assert file_of(library()) == str(tmp_path / NAME)
        library.cache_clear()


def test_without_it_one_line_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(kernels, "__path__", [str(tmp_path)])
    with pytest.raises(EnvironmentTrouble) as trouble:
        library()
    remedy = "build them by ./in-env rockslip ..., or by pip install anew"
    assert str(trouble.value) == f"the compiled kernels are missing, no {tmp_path / NAME}; {remedy}"
    (tmp_path / NAME).write_text("no library")
    with pytest.raises(EnvironmentTrouble, match=r"kernels cannot be loaded: .*librockslip\.so"):
        library()


def test_one_of_other_sources_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Sources that were changed since, and a library of something else."""
    monkeypatch.setenv(VARIABLE, file_of(library()))
    library.cache_clear()
    sources = tmp_path / "kernels"
    shutil.copytree(KERNELS, sources)
    monkeypatch.setattr(kernels, "__path__", [str(sources)])
    assert library()
    library.cache_clear()
    (sources / "world.hpp").write_text("// another world\n")
    with pytest.raises(EnvironmentTrouble, match=r"are of other sources; build them by ./in-env"):
        library()
    monkeypatch.setenv(VARIABLE, _multiarray_umath.__file__)
    with pytest.raises(EnvironmentTrouble, match=r"cannot be loaded: .*PyInit_kernels"):
        library()


@pytest.mark.slow
@NEEDS_COMPILER
def test_sanitizers_and_compiler_find_nothing(tmp_path: Path) -> None:
    """In dominoes, a wall, blocks in space, the law of points; what is there, they find.

    Nor does the compiler warn.
    """
    built = build(tmp_path / NAME, *SANITIZERS, "-Wall", "-Wextra", "-Wshadow", "-Werror")
    assert built.returncode == 0, built.stderr
    preloaded = [
        subprocess.run(
            ["g++", f"-print-file-name=lib{name}.so"], capture_output=True, text=True, check=True
        ).stdout.strip()
        for name in ("asan", "ubsan")
    ]
    environment = {
        **os.environ,
        VARIABLE: str(tmp_path / NAME),
        "LD_PRELOAD": " ".join(preloaded),
        "ASAN_OPTIONS": "detect_leaks=0",
        "PYTHONMALLOC": "malloc",  # in Python's own pools the ends of arrays are not seen
        "PYTHONPATH": str(REPOSITORY),
    }

    def python(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=REPOSITORY,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    tests = ["tests/verification/test_dominoes.py"]
    tests += [f"tests/unit/test_{name}.py" for name in ("friction", "local_problem")]
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", *tests)
    assert done.returncode == 0 and " passed" in done.stdout, done.stdout + done.stderr
    (tmp_path / "space.toml").write_text(SPACE)
    wall = ("demos/wall/scene.toml", "--set", "time.end=0.2", "output.fields=none")
    for number, scene in enumerate((wall, (str(tmp_path / "space.toml"),))):
        done = python("-m", "rockslip", "run", *scene, "-o", str(tmp_path / f"out{number}"))
        assert done.returncode == 0 and "completed at" in done.stdout, done.stdout + done.stderr
    done = python("-c", BEYOND)
    assert done.returncode != 0 and "AddressSanitizer: heap-buffer-overflow" in done.stderr
