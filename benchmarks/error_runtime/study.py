"""A scene over its ladders: run, timed, and judged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter, process_time

from mpi4py import MPI

from benchmarks.error_runtime.findings import Beside, Findings
from benchmarks.error_runtime.ladders import (
    NAMES,
    RunOutcome,
    Trial,
    climb,
    coarsest_step,
    families,
)
from benchmarks.error_runtime.machine import machine
from benchmarks.error_runtime.measures import chosen, measures, words
from benchmarks.error_runtime.reference import references
from benchmarks.error_runtime.table import as_csv, everything, text
from solver.errors import SceneError
from solver.excitation.motion import read_ground
from solver.results.endings import cut_short, motion_end
from solver.run.simulate import simulate
from solver.scene import Scene
from solver.study.tables import write as write_file

#: What a row of the table counts.
COUNTS = ("unknowns", "steps", "rejected_steps", "newton_iterations")

#: What it says of the energy.
BALANCE = ("largest_gain_fraction", "ledger_error_fraction")

#: Panels of the picture, at most, where no measures are asked for.
PANELS = 4

Tell = Callable[[str], None]


def study(
    scene: Scene,
    *,
    names: Sequence[str] = NAMES,
    wanted: Sequence[str] = (),
    rungs: int = 6,
    repeat: int = 3,
    longest: float = 60.0,
    target: float = 0.01,
    others: Sequence[Beside] = (),
    answered_by: Scene | None = None,
    tell: Tell = lambda line: None,
) -> Findings:
    """Run a scene over its ladders, one run after the other, and judge every run.

    Args:
        scene: Where the ladders start.
        names: Families, of `NAMES`.
        wanted: Measures, the one that counts most first; empty: all there are.
        rungs: Of the ladder of steps.
        repeat: Times that each run is made.
        longest: Runs that would take longer than this are left out, s.
        target: Relative error that is aimed at.
        others: Points of other programs.
        answered_by: A scene whose rigid-body answer is that of this one in what is wanted, such as
            one in the plane.
        tell: Called with a line for every run.
    """
    plain = replace(scene, output=replace(scene.output, fields="none", history_every=1))
    every = coarsest_step(plain)
    made = families(plain, names, rungs, partial(solve, every=every))
    trials, left_out = climb(
        made, repeat=repeat, longest=longest, tell=lambda trial: tell(_line(trial))
    )
    found = references(plain, trials, every, answered_by)
    if not found:
        got = f"{sum(t.outcome.completed for t in trials)} completed runs in which nothing moves"
        raise SceneError("time.step", got, "two completed runs or more of a block that moves")
    motion = motion_end(read_ground(scene))
    early = cut_short({"end_s": scene.time.end, "motion_end_s": motion})
    blocks = tuple(block.name for block in scene.blocks)
    judged, missing = chosen(list(found), wanted)
    return Findings(
        title="; ".join(filter(None, (scene.title or "without a title", early))),
        machine=machine(),
        repeat=repeat,
        trials=trials,
        left_out=[*left_out, *(f"{name}, which no run tells" for name in missing)],
        references=found,
        names={measure: words(measure, blocks) for measure in judged},
        target=target,
        others=[other for other in others if other.measure in judged],
    )


def solve(scene: Scene, every: float) -> RunOutcome:
    """One run, on this process alone."""
    began, worked = perf_counter(), process_time()
    result = simulate(scene, comm=MPI.COMM_SELF)
    share = (process_time() - worked) / (perf_counter() - began)
    if result.status == "interrupted":
        raise KeyboardInterrupt
    summary, cost = result.summary, result.summary["cost"]
    completed = result.status == "completed"
    counts = {name: cost[name] for name in COUNTS}
    energy = {name: summary["energy"][name] for name in BALANCE}
    return RunOutcome(
        measures=measures(scene, result.history, summary, every) if completed else {},
        loop_s=cost["wall_s"],
        setup_s=cost["setup_s"],
        status=result.status,
        counts=counts | energy | {"processor_share": share},
        modes={name: block["mode"] for name, block in summary["blocks"].items()},
    )


def write(findings: Findings, folder: Path) -> list[Path]:
    """Write table, text, JSON and picture; returns the files."""
    from benchmarks.error_runtime.picture import picture

    files = [folder / f"errors.{kind}" for kind in ("csv", "txt", "json", "png")]
    write_file(files[0], as_csv(findings))
    write_file(files[1], text(findings))
    write_file(files[2], everything(findings))
    picture(findings, files[3], list(findings.names)[:PANELS])
    return files


def _line(trial: Trial) -> str:
    """A line on a run, for the display."""
    outcome = trial.outcome
    said = f"{trial.loop_s:.3g} s" if outcome.completed else outcome.status
    return f"{trial.family.name}, {trial.rung.setting}: {said}"
