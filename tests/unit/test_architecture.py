"""The house keeps its shape: arrows point one way, without circles; names say where things are."""

import importlib.util
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def drawing() -> ModuleType:
    """The script that draws the packages."""
    file = REPOSITORY / "docs" / "draw_architecture.py"
    spec = importlib.util.spec_from_file_location("draw_architecture", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_imports_point_one_way(drawing: ModuleType) -> None:
    """No package imports from one below it, not even inside a function."""
    assert drawing.upward(drawing.imports(lazy=True)) == []


def test_imports_have_no_circles(drawing: ModuleType) -> None:
    """Not even by imports inside functions."""
    assert drawing.circles(drawing.imports(lazy=True)) == []


def test_a_circle_and_an_arrow_upwards_are_found(drawing: ModuleType) -> None:
    graph = {"solver.law.a": {"solver.rigid.b"}, "solver.rigid.b": {"solver.law.a"}}
    assert drawing.upward(graph) == ["solver.law.a -> solver.rigid.b"]
    assert drawing.circles(graph) == ["solver.law.a > solver.rigid.b > solver.law.a"]


def test_every_package_has_its_place(drawing: ModuleType) -> None:
    packages = {drawing.package_of(module) for module in drawing.modules()}
    assert packages - drawing.SHARED - {"solver"} <= set(drawing.ORDER)


def test_the_program_runs_without_benchmarks(drawing: ModuleType) -> None:
    """Only studies of the program itself take what they need from there."""
    words = ("from benchmarks", "import benchmarks", '"benchmarks.')
    users = [
        name
        for name, file in drawing.modules().items()
        if any(word in file.read_text() for word in words)
    ]
    assert users == ["solver.study.command"]


def test_few_files_stand_at_the_root_of_the_solver() -> None:
    assert len(list((REPOSITORY / "solver").glob("*.py"))) <= 10


def test_no_prefix_of_file_names_stands_for_a_folder(drawing: ModuleType) -> None:
    """Three files of one folder that begin with the same word want a folder of their own."""
    words = Counter(
        (file.parent, file.stem.split("_")[0])
        for file in drawing.modules().values()
        if "_" in file.stem.strip("_")
    )
    assert [where for where, count in words.items() if count > 2] == []
