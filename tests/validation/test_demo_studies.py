"""Demos of studies, with few motions and points: their checks hold, can fail, and know ranks."""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest
from processes import ROOT, python

from demos.study import read_table
from solver.cli import build_parser

pytestmark = pytest.mark.serial


class Demo(NamedTuple):
    """A demo in its short form.

    Attributes:
        script: Its module.
        words: Options of the short form.
        holds: Number of checks that hold.
        engines: In its table.
        spoiled: Keys of a number in its summary, and another one,
        fails: with which the check of this number fails.
    """

    script: str
    words: str
    holds: int
    engines: set[str]
    spoiled: tuple[tuple[Any, ...], Any]
    fails: int


DEMOS = {
    "modes": Demo(
        "modes", "--engines rigid --points 6", 2, {"rigid"}, (("maps", 0, "agree"), 0), 0
    ),
    "overturning": Demo(
        "overturning", "--frequencies 2,4 --amplitudes 1:5:16 --rounds 0", 2,
        {"rigid"}, (("completed",), 3), 0,
    ),
    "ensemble": Demo(
        "ensemble", "--count 4 --levels 0.2,0.5,1.5 --set time.step=2e-3", 4,
        {"rigid", "ode"}, (("distances", 1, "angle"), 1.2), 2,
    ),
}  # fmt: skip


def module_of(name: str, script: str) -> ModuleType:
    return importlib.import_module(f"demos.{name}.{script}")


@pytest.fixture(scope="module")
def left(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Path, str]]:
    """What the short form of a demo leaves and prints, each made once."""
    pytest.importorskip("matplotlib")

    @cache
    def made(name: str) -> tuple[Path, str]:
        demo, folder = DEMOS[name], tmp_path_factory.mktemp(name) / "out"
        words = [*demo.words.split(), "-q", "-j", "1", "-o", str(folder)]
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            assert module_of(name, demo.script).main(words) == 0
        return folder, printed.getvalue()

    return made


@pytest.mark.parametrize("name", list(DEMOS))
def test_the_image_tries_it_with_options_that_it_has(name: str) -> None:
    lines = (ROOT / ".ci" / "image").read_text().splitlines()
    words = next(line for line in lines if line.strip().startswith(f"{name}) echo -"))
    options = words.split("echo ")[1].removesuffix(" ;;").split()
    command = module_of(name, DEMOS[name].script).COMMAND
    given = build_parser().parse_args(["study", *command, *options])
    assert given.study == command[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", list(DEMOS))
def test_its_checks_hold_and_can_fail(
    name: str, left: Callable[[str], tuple[Path, str]], tmp_path: Path
) -> None:
    demo, (made, printed) = DEMOS[name], left(name)
    assert printed.count("holds:") == demo.holds
    module, folder = module_of(name, demo.script), Path(shutil.copytree(made, tmp_path / "out"))
    table = "suite" if name == "ensemble" else name
    assert {row["engine"] for row in read_table(folder / f"{table}.csv")} == demo.engines
    file = folder / "summary.json"
    summary = json.loads(file.read_text())
    (*keys, last), value = demo.spoiled
    place = summary
    for key in keys:
        place = place[key]
    place[last] = value
    file.write_text(json.dumps(summary))
    results = [good for good, _ in module.checks(folder)]
    assert [number for number, good in enumerate(results) if not good] == [demo.fails]


@pytest.mark.slow
def test_the_live_load(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    demo = module_of("inertia", "live_load")
    assert demo.main(["-o", str(tmp_path / "output"), "--count", "2", "-q", "-j", "1"]) == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert output.out.count("holds:") == 4 + 3
    assert (tmp_path / "output" / "map" / "lambda.png").stat().st_size > 20_000
    row = {"period_s": "1", "friction": "0.1", "by": "sliding block", "lambda": "0.5",
           "lambda_low": "0.4"}  # fmt: skip
    rigid = row | {"by": "rigid blocks", "lambda": "0.504"}
    results = demo.checks([row | {"lambda": "0.6", "lambda_low": "0.55"}, row], [row, rigid])
    assert demo.verdict("live_load", results) == 1
    error = capsys.readouterr().err
    assert "T 1 s: 0.600, 0.500, growing" in error
    assert "friction 0.1: 0.5040 by rigid blocks, 0.5000 by the sliding block" in error


@pytest.mark.slow
@pytest.mark.mpi
def test_it_does_the_same_on_two_ranks(
    left: Callable[[str], tuple[Path, str]], tmp_path: Path
) -> None:
    """Rounds of cases: the same tables as on one, and the verdict of one rank."""
    demo, file = DEMOS["overturning"], ROOT / "demos" / "overturning" / "overturning.py"
    two = tmp_path / "two"
    done = python(file, "-q", "-o", two, *demo.words.split(), ranks=2, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "check failed" not in done.stderr
    assert done.stdout.count("holds:") == demo.holds
    rows = [read_table(folder / "overturning.csv") for folder in (left("overturning")[0], two)]
    assert rows[0] == rows[1] != []
