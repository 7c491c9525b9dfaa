"""Steps of the program against the same steps by a textbook semi-smooth Newton method.

    ./in-env python3 benchmarks/full_newton.py [--cases 2-D-5k ...] [--steps 12]

Writes `benchmarks/full_newton.csv`, a row for each case: a block that rocks on one corner or edge
and lands on the other after 5 ms, in fixed steps of 1 ms. Both ways solve the same equations from
the same guesses to the same residual; `benchmarks/newton/` has the other one: in each iteration the
tangent is assembled by dolfinx and factorized by MUMPS (nested dissection). Times are means of the
steps after the first two, without what is done once: factorizations and W of the program, the mass
of both. It ends with an error where displacements (over the largest way of the step) or forces
(over the largest) differ by more than 1e-6 in any step. One process, one thread, 4 GB.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from benchmarks.newton.solve import FullNewton
from benchmarks.rows import write_table
from rockslip import Scene, parse_scene
from solver.bodies.factorization import Factorization
from solver.build.assembly import build, initial_state
from solver.stepping.compliance import Compliance
from solver.stepping.contact_solve import ContactSolve
from solver.stepping.stepper import Stepper
from solver.types import Array

TABLE = Path(__file__).with_suffix(".csv")
GRANITE = {"young": 5e10, "poisson": 0.2, "density": 503.0 / (0.25 * 0.75)}
"""The paper's block, 0.25 m x 1 m."""
SOFT = {"young": 5e9, "poisson": 0.2, "density": 2000.0}
"""Ten times as soft, of a block four times as wide: larger strains, more corrections."""
CASES: dict[str, tuple[tuple[int, ...], float, dict[str, float]]] = {
    "2-D-5k": ((25, 100), 0.25, GRANITE),
    "2-D-50k": ((80, 322), 0.25, GRANITE),
    "3-D-50k": ((15, 15, 64), 0.25, GRANITE),
    "2-D-5k-soft": ((36, 70), 1.0, SOFT),
    "2-D-50k-soft": ((114, 228), 1.0, SOFT),
    "3-D-50k-soft": ((17, 17, 52), 1.0, SOFT),
}
"""Cells, width and material."""
STEP = 1e-3
SPIN = -0.5
"""Of the block towards its landing, rad/s."""
LANDING = 5e-3
"""When it lands, s."""
FIRST = 2
"""Steps in which factorizations and W are made, one for each rho_inf."""
AGREEMENT = 1e-6
"""What steps of both ways may differ by."""


def scene_of(
    cells: tuple[int, ...], width: float = 0.25, material: dict[str, float] = GRANITE
) -> Scene:
    """A block that turns about its right corner or edge and is about to land on the left one."""
    d, height = len(cells), width * cells[-1] / cells[0]
    tilt = -SPIN * LANDING
    # From the corner to the centre; a block turns clockwise about what it stands on.
    arm = np.array([-width, height]) / 2
    turned = np.array([[math.cos(tilt), math.sin(tilt)], [-math.sin(tilt), math.cos(tilt)]]) @ arm
    velocity = SPIN * np.array([turned[1], -turned[0]])
    block: dict[str, Any] = {
        "width": width,
        "height": height,
        "cells": list(cells),
        "tilt_deg": math.degrees(tilt),
        "angular_velocity": SPIN if d == 2 else [0.0, SPIN, 0.0],
        "velocity": [velocity[0], *[0.0] * (d - 2), velocity[1]],
        **material,
    }
    if d == 3:
        block["thickness"] = width
    return parse_scene(
        {
            "dimension": d,
            "block": [block],
            "contact": {"friction": 0.6},
            "time": {"end": 1.0, "step": STEP},
        }
    )


class Spent(NamedTuple):
    """Seconds of the processor and of the clock."""

    cpu: float
    wall: float

    @classmethod
    def now(cls) -> Spent:
        """What has been spent since whenever."""
        return cls(time.process_time(), time.perf_counter())

    def less(self, other: Spent) -> Spent:
        """The difference."""
        return Spent(self.cpu - other.cpu, self.wall - other.wall)

    def plus(self, other: Spent) -> Spent:
        """The sum."""
        return Spent(self.cpu + other.cpu, self.wall + other.wall)


NOTHING = Spent(0.0, 0.0)


class Clock:
    """Time spent in some methods, without what they spend in others that are done once."""

    def __init__(self, *once: str) -> None:
        """Start from nothing; `once` are the names of the latter."""
        self._once, self._spent = once, dict[str, Spent]()

    @contextmanager
    def measuring(self, **methods: tuple[type, str]) -> Iterator[None]:
        """Measure these methods meanwhile."""
        originals = [(of, method, getattr(of, method)) for of, method in methods.values()]
        for name, (of, method, original) in zip(methods, originals, strict=True):
            setattr(of, method, self._measured(name, original))
        try:
            yield
        finally:
            for of, method, original in originals:
                setattr(of, method, original)

    def _measured(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        """The same that adds its time to that of a name."""

        def measured(*arguments: Any, **options: Any) -> Any:
            begin, before = Spent.now(), self.of(*self._once)
            try:
                return original(*arguments, **options)
            finally:
                took = Spent.now().less(begin)
                if name not in self._once:
                    took = took.less(self.of(*self._once).less(before))
                self._spent[name] = self.of(name).plus(took)

        return measured

    def of(self, *names: str) -> Spent:
        """The time of some names together."""
        total = NOTHING
        for name in names:
            total = total.plus(self._spent.get(name, NOTHING))
        return total


class StepTaken(NamedTuple):
    """A step and what it took, without what is done once."""

    u: Array
    way: float
    """Largest displacement in it, m."""
    force: Array
    iterations: int
    step: Spent
    solve: Spent
    """Of its nonlinear solve alone."""


class Run(NamedTuple):
    """A run one way."""

    steps: list[StepTaken]
    unknowns: int
    factorizations: Spent
    compliance: Spent
    newton: FullNewton | None


def run(scene: Scene, steps: int, *, full: bool) -> Run:
    """Step a scene by the program's solve or by the full Newton method."""
    assembly = build(scene)
    once = "factorizations", "W"
    stepper, clock, taken = assembly.stepper, Clock(*once), list[StepTaken]()
    state, _ = initial_state(scene, assembly)
    newton = FullNewton(stepper.system, stepper.links) if full else None
    if newton is not None:
        stepper._solve = newton  # type: ignore[assignment]
    with clock.measuring(
        factorizations=(Factorization, "_factorized"),
        W=(Compliance, "_compute"),
        solve=(FullNewton if full else ContactSolve, "solve"),
        step=(Stepper, "advance"),
    ):
        for _ in range(steps):
            before = clock.of("step"), clock.of("solve")
            new, exchange = stepper.advance(state, STEP)
            taken.append(
                StepTaken(
                    new.u,
                    float(np.abs(new.u - state.u).max()),
                    new.contacts[0].force,
                    exchange.iterations,
                    clock.of("step").less(before[0]),
                    clock.of("solve").less(before[1]),
                )
            )
            state = new
    return Run(taken, stepper.system.unknowns, clock.of(once[0]), clock.of(once[1]), newton)


def agreement(one: Run, other: Run) -> tuple[float, float]:
    """Largest differences of displacements, over ways, and of forces, over forces, of any step."""
    apart, forces = 0.0, 0.0
    for a, b in zip(one.steps, other.steps, strict=True):
        apart = max(apart, float(np.abs(a.u - b.u).max()) / a.way)
        largest = float(np.abs(a.force).max()) or 1.0
        forces = max(forces, float(np.abs(a.force - b.force).max()) / largest)
    return apart, forces


def changes(found: Run) -> int:
    """Steps in which points open or close."""
    closed = [step.force[:, 0] > 0 for step in found.steps]
    return sum(bool(np.any(a != b)) for a, b in itertools.pairwise(closed))


def mean(found: Run, which: str, what: str) -> float:
    """Mean of a time of the steps after the first, ms."""
    return 1e3 * statistics.mean(getattr(getattr(step, which), what) for step in later(found))


def later(found: Run) -> list[StepTaken]:
    """The steps after those in which factorizations and W are made."""
    return found.steps[FIRST:]


def row(name: str, steps: int) -> dict[str, Any]:
    """Both ways of a case, and how they agree."""
    scene = scene_of(*CASES[name])
    ours, textbook = (run(scene, steps, full=full) for full in (False, True))
    apart, forces = agreement(ours, textbook)
    if max(apart, forces) > AGREEMENT:
        sys.exit(f"{name}: displacements differ by {apart:.1e}, forces by {forces:.1e}")
    newton = textbook.newton
    assert newton is not None
    count = [
        statistics.mean(step.iterations for step in later(found)) for found in (ours, textbook)
    ]
    medians = [statistics.median(s.step.cpu for s in later(found)) for found in (ours, textbook)]
    table: dict[str, Any] = {
        "case": name,
        "dimension": len(CASES[name][0]),
        "unknowns": ours.unknowns,
        "steps": steps,
        "steps_with_changes": changes(ours),
        "corrections_a_step": f"{count[0]:.2f}",
        "newton_iterations_a_step": f"{count[1]:.2f}",
    }
    for which, what in itertools.product(("step", "solve"), ("cpu", "wall")):
        mine, theirs = mean(ours, which, what), mean(textbook, which, what)
        table[f"{which}_{what}_ms"] = f"{mine:.4g}"
        table[f"{which}_{what}_ms_full_newton"] = f"{theirs:.4g}"
        table[f"{which}_{what}_ratio"] = f"{theirs / mine:.3g}"
    table["step_cpu_ratio_of_medians"] = f"{medians[1] / medians[0]:.3g}"
    total = sum(step.iterations for step in textbook.steps)
    for part, seconds in newton.seconds.items():
        table[f"{part}_ms_an_iteration"] = f"{1e3 * seconds / total:.4g}"
    return table | {
        "once_factorizations_s": f"{ours.factorizations.cpu:.3g}",
        "once_W_s": f"{ours.compliance.cpu:.3g}",
        "once_analysis_full_newton_s": f"{newton.analysed:.3g}",
        "displacements_differ_by": f"{apart:.1e}",
        "forces_differ_by": f"{forces:.1e}",
    }


def main() -> int:
    """Run the cases and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--steps", type=int, default=12)
    parser.add_argument("--to", type=Path, default=TABLE, help="another file")
    options = parser.parse_args()
    run(scene_of((4, 8)), 8, full=False), run(scene_of((4, 8)), 8, full=True)  # what compiles
    run(scene_of((2, 2, 5)), 8, full=False), run(scene_of((2, 2, 5)), 8, full=True)
    for found in write_table(options.to, (row(name, options.steps) for name in options.cases)):
        print(", ".join(f"{key} {value}" for key, value in found.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
