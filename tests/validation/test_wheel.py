"""The wheel: its name and version, modules and compiled kernels and nothing else, its command."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest

from solver import VERSION
from solver.kernels.library import VARIABLE

pytestmark = [pytest.mark.serial, pytest.mark.slow]

ROOT = Path(__file__).parents[2]
PACKAGES = ("geometry", "solver")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> ZipFile:
    """The wheel of a copy of the sources, which a build would write into."""
    for package in ("pip", "scikit_build_core"):
        pytest.importorskip(package)
    folder = tmp_path_factory.mktemp("wheel")
    for name in ("pyproject.toml", "CMakeLists.txt", "README.md", "LICENSE", "rockslip.py"):
        shutil.copy(ROOT / name, folder)
    for name in PACKAGES:
        unwanted = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=unwanted)
    quick = folder / "compiler"  # the last of several -O counts
    quick.write_text(f'#!/bin/sh\nexec {os.environ.get("CXX", "g++")} "$@" -O0\n')
    quick.chmod(0o755)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    built = subprocess.run(
        [*command, "-w", str(folder / "out"), str(folder)],
        env=os.environ | {"CXX": str(quick)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    (file,) = (folder / "out").iterdir()
    platform = sysconfig.get_platform().replace("-", "_")
    assert file.name == f"rockslip-{VERSION}-cp311-abi3-{platform}.whl"
    return ZipFile(file)


def test_it_holds_all_modules_and_the_kernels(wheel: ZipFile) -> None:
    sources = [file for name in PACKAGES for file in (ROOT / name).rglob("*.py*")]
    sources = [file for file in sources if file.suffix in (".py", ".pyi")]
    modules = {str(file.relative_to(ROOT)) for file in sources} | {"rockslip.py"}
    modules.add("solver/kernels/librockslip.so")
    names = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert names == modules


def test_its_kernels_are_found(wheel: ZipFile, tmp_path: Path) -> None:
    wheel.extractall(tmp_path)
    found = "from solver.kernels import library, meshed; meshed.solve; "
    found += "print(library.library().__file__)"
    environment = {name: value for name, value in os.environ.items() if name != VARIABLE}
    done = subprocess.run(
        [sys.executable, "-c", found],
        env=environment | {"PYTHONPATH": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.strip() == str(tmp_path / "solver/kernels/librockslip.so"), done.stderr


def test_it_brings_the_command(wheel: ZipFile) -> None:
    text = wheel.read(f"rockslip-{VERSION}.dist-info/entry_points.txt").decode()
    assert re.search(r"^\[console_scripts\]\nrockslip = solver\.cli:main$", text, re.MULTILINE)


@pytest.mark.parametrize("file", ["CITATION.cff", "conda/recipe.yaml"])
def test_versions_agree(file: str) -> None:
    assert re.findall(r"version: \"?([\d.]+)", (ROOT / file).read_text())[-1] == VERSION


def test_the_conda_recipe_asks_for_what_the_wheel_needs() -> None:
    """With the same bounds; and for what pip has no builds of."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    options = project["optional-dependencies"]
    extras = ("pictures", "progress")
    needed = [*project["dependencies"], *(each for name in extras for each in options[name])]
    needed.append(f"python{project['requires-python']}")
    recipe = (ROOT / "conda" / "recipe.yaml").read_text()
    run = recipe.split("  run:\n")[1].split("\ntests:")[0]
    asked = {line.strip().removeprefix("- ").replace(" ", "") for line in run.splitlines()}
    asked = {line.replace("matplotlib-base", "matplotlib") for line in asked}
    assert set(needed) <= asked
    others = {line.split(">")[0] for line in asked - set(needed)}
    assert others == {"fenics-dolfinx", "mpi4py", "petsc4py", "python-gmsh"}
