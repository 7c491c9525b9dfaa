"""The tutorial: its scene is the demo's, and today's program prints what stands on the page.

tests/validation/test_readme.py runs its commands.
"""

from __future__ import annotations

import re
from pathlib import Path
from textwrap import dedent

import pytest

from rockslip import load_scene, simulate
from solver.run.describe import describe

pytestmark = pytest.mark.serial

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "demos" / "pedestal" / "scene.toml"
PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")


def blocks() -> list[str]:
    """The indented texts of the page."""
    found = re.findall(r"(?:^ {4}.*\n|^\n(?= {4}))+", PAGE, re.MULTILINE)
    return [dedent(text) for text in found]


def number(pattern: str) -> float:
    """The number that the page gives in a phrase."""
    found = re.search(pattern, PAGE)
    assert found is not None, pattern
    return float(found[1])


def test_the_scene_is_that_of_the_demo() -> None:
    scene = SCENE.read_text(encoding="utf-8").split("\n", 1)[1]  # without what the file says first
    assert scene.strip() in [block.strip() for block in blocks()]


def test_check_prints_what_stands_there() -> None:
    printed = describe(load_scene(SCENE)).splitlines()
    (shown,) = [block for block in blocks() if block.strip().startswith("block  ")]
    lines = [line.rstrip() for line in shown.strip("\n").splitlines()]
    assert len(lines) > 5
    assert set(lines) <= {line.rstrip() for line in printed}


@pytest.mark.slow
def test_the_run_says_what_stands_there() -> None:
    """The largest angle, when it comes, and up to when run and twin agree."""
    result = simulate(load_scene(SCENE))
    block = result.summary["blocks"]["block"]
    assert block["mode"] == "rock"
    largest = max(block["peaks"], key=lambda peak: peak["angle_rad"])
    angle = block["peak_angle_rad"] * 57.29578
    assert angle == pytest.approx(number(r"block: rock, peak angle ([\d.]+) degrees"), abs=2e-3)
    assert largest["time_s"] == pytest.approx(number(r"degrees, ([\d.]+) s after"), abs=0.05)
    horizon = result.summary["horizon"]["time_s"]
    # A last digit that differs, as on another machine, moves it a little.
    assert horizon == pytest.approx(number(r"something up to t = ([\d.]+) s"), abs=1.0)
    assert horizon > largest["time_s"]
