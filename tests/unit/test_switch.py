"""Machine code or interpreter: chosen for each run, from the command line and from Python alike."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest
from processes import outside_mpirun

from solver.law import switch
from solver.law.compiled import NUMBA, compiled, runs_machine_code

REPOSITORY = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(NUMBA is None, reason="numba is not installed")


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that has run nothing yet."""
    monkeypatch.setattr(switch.CHOICE, "spent", 0.0)


def test_short_runs_are_interpreted_until_the_import_would_have_paid() -> None:
    """Longer ones, and those that cannot be interpreted, never."""
    chosen = []
    for steps in (400.0, math.inf, 500.0, 1e6, 200.0, 100.0):
        with switch.chosen_for(steps):
            chosen.append(runs_machine_code())
        assert runs_machine_code()
    assert chosen == [False, True, False, True, True, False]


def test_a_function_does_the_same_both_ways() -> None:
    """Also where it calls another one."""

    @compiled
    def double(x: float) -> float:
        """Twice x."""
        return 2 * x

    @compiled
    def quadruple(x: float) -> float:
        """Four times x."""
        return double(double(x))

    with switch.chosen_for(1.0):
        assert quadruple(1.5) == 6.0
    assert quadruple(1.5) == 6.0
    assert quadruple.__doc__ == "Four times x."


NUMBER = 1


@compiled
def number() -> int:
    """The number that the code knows."""
    return NUMBER


def test_a_function_follows_every_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Machine code knows a number as it was when it was made, the interpreter as it is."""
    assert number() == 1
    monkeypatch.setitem(globals(), "NUMBER", 2)
    found = []
    for steps in (1.0, math.inf, 1.0, 1.0, math.inf):
        with switch.chosen_for(steps):
            found.append(number())
            with switch.chosen_for(math.inf):
                found.append(number())
    assert found == [2, 1, 1, 1, 2, 1, 2, 1, 1, 1]


SCRIPT = """
import sys
from rockslip import parse_scene, simulate
block = {"width": 0.25, "height": 1.0, "mass": 503.0, "model": "rigid", "tilt_deg": 3.0}
def run(end, **options):
    scene = parse_scene({"block": [block], "time": {"end": end, "step": 1e-3}})
    simulate(scene, **options)
    return "numba" in sys.modules
print(run(0.04), run(0.04), run(0.04, many=True))
"""


def test_python_and_the_command_line_choose_alike() -> None:
    """Short runs from Python do not wait for numba; test_cli_run has those of the command line."""
    environment = outside_mpirun()
    environment.pop(switch.SWITCH, None)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=environment | {"PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["False", "False", "True"]
