"""Calibration: the damping with which the impacts of a scene keep what was measured."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from solver.errors import NotConverged, SceneError, Statement
from solver.run.streams import say
from solver.study.damping.axes import AXES, Axis
from solver.study.damping.case import BaseScene
from solver.study.damping.command import base_scene, claimed, run_cases
from solver.study.damping.search import Search, Trial
from solver.study.damping.sweep import chosen_axes
from solver.study.damping.target import Target, target_of

CLOSE = 4e-3
"""Difference from a restitution, or from peaks over that of the release, that is good enough."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationPlan:
    """Plan of a calibration.

    Attributes:
        base: What is calibrated.
        folder: Where it goes.
        axis: The parameter.
        bounds: Its least and largest value.
        target: What runs are compared with.
        rows: Rows of the cases that have been done before, by key.
    """

    base: BaseScene
    folder: Path
    axis: Axis
    bounds: tuple[float, float]
    target: Target
    rows: dict[str, dict[str, Any]]


def calibrate(options: argparse.Namespace, comm: Any) -> int:
    """Search and write; 0 where the target was met, 3 where a run failed or nothing came near."""
    from solver.parallel import on_first_rank

    plan: CalibrationPlan = on_first_rank(comm, lambda: prepare(options))
    rows = dict(plan.rows)
    target = plan.target
    search = Search(
        low=plan.bounds[0],
        high=plan.bounds[1],
        wanted=target.wanted,
        restitution=target.restitution,
    )
    try:
        while values := comm.bcast(search.ask()):
            cases = [plan.base.case((plan.axis, value)) for value in values]
            run_cases(cases, rows, plan.folder, options)
            for value, case in zip(values, cases, strict=True):
                row = comm.bcast(rows.get(case.key))
                search.tell(_trial(plan, value, row))
    finally:
        if comm.rank == 0 and search.made:
            _write(plan, search)
    if not search.within_reach:
        least, largest = search.reach
        got = f"{target.restitution:.4g}"
        raise SceneError("--target", got, _words_of_reach(plan, least, largest))
    close = search.best_error <= CLOSE
    if comm.rank == 0 and not options.quiet:
        _tell(plan, search, close)
    return 0 if close else NotConverged.exit_code


def prepare(options: argparse.Namespace) -> CalibrationPlan:
    """Look at everything that can be refused before anything is run, and claim the folder."""
    from solver.study.folder import finished

    if options.at:
        raise SceneError("--at", " ".join(options.at), "nothing with --target")
    base = base_scene(options)
    able = [axis for axis in AXES.values() if axis.bounds is not None]
    chosen = chosen_axes(options.of or [able[0].name], "--of")
    (name, values), *others = chosen.items()
    axis = AXES[name]
    names = " or ".join(each.name for each in able)
    if others or axis.bounds is None:
        raise SceneError("--of", " ".join(options.of), f"{names} with --target")
    if values and not (len(values) == 2 and 0 < values[0] < values[1]):
        raise SceneError("--of", " ".join(options.of), f"{name}=LEAST,LARGEST, both > 0")
    bounds = (values[0], values[1]) if values else axis.bounds(base.scene, base.block)
    target = target_of(options.target, base.scene, base.block, options.impacts)
    for value in bounds:
        base.case((axis, value))  # what the scene does not take is refused here
    folder = claimed(options, base)
    return CalibrationPlan(
        base=base, folder=folder, axis=axis, bounds=bounds, target=target, rows=finished(folder)
    )


def _trial(plan: CalibrationPlan, value: float, row: dict[str, Any]) -> Trial:
    """The trial of a row; refused where it has too few impacts."""
    from solver.study.damping.restitution import Restitution

    where = f"{plan.axis.name} {value:g}"
    if row is None or row["status"] != "completed":
        raise NotConverged(f"{where}: {'interrupted' if row is None else row['reason']}")
    known = Restitution.of(row, plan.target.impacts)
    found = plan.target.of(row)
    if found is None or known.mean is None:
        missing = known.too_few(row["end_s"]) or "too few peaks"
        raise Statement("--target", f"is out of reach: {where} has {missing}")
    return Trial(value=value, restitution=known.mean, found=found)


def _words_of_reach(plan: CalibrationPlan, least: float, largest: float) -> str:
    """What can be reached, in words."""
    low, high = plan.bounds
    return f"{least:.4f} to {largest:.4f}, the reach of {plan.axis.name} {low:g} to {high:g}"


def _write(plan: CalibrationPlan, search: Search) -> None:
    """Write table, picture, summary and, where the target is within reach, the scene."""
    import tomli_w

    from solver.study.damping.calibration_picture import calibration_picture
    from solver.study.damping.folder import kept_angle
    from solver.study.tables import as_csv, column_names, write

    table = _table(plan, search)
    write(plan.folder / "calibration.csv", as_csv(table, column_names(table), digits=8))
    write(plan.folder / "calibration.md", _markdown(plan, search))
    best = search.best if search.within_reach else None
    least, largest = search.reach
    summary = {
        "parameter": plan.axis.name,
        "key": plan.axis.key,
        "unit": plan.axis.unit,
        "target_restitution": plan.target.restitution,
        "target_peaks": list(plan.target.peaks),
        "reach": [least, largest],
        "runs": len(search.trials),
        "value": best.value if best else None,
        "restitution": best.restitution if best else None,
        "difference": search.best_error if best else None,
    }
    write(plan.folder / "summary.json", summary)
    if best is not None:
        tables = plan.base.with_values((plan.axis, best.value))
        write(plan.folder / "calibrated.toml", tomli_w.dumps(tables))
    angle = None
    if best is not None:
        angle = kept_angle(plan.folder, plan.base.case((plan.axis, best.value)).key)
    file = plan.folder / "calibration.png"
    calibration_picture(search, plan.target, plan.axis.label, angle, file)


def _table(plan: CalibrationPlan, search: Search) -> list[dict[str, Any]]:
    """Rows of the runs, by value."""
    return [
        {
            plan.axis.name: trial.value,
            "restitution": trial.restitution,
            "difference": search.error(trial),
            **{f"peak_{k}": found for k, found in enumerate(trial.found, start=1) if _peaks(plan)},
        }
        for trial in search.trials
    ]


def _peaks(plan: CalibrationPlan) -> bool:
    """Whether peaks are compared, not a restitution."""
    return bool(plan.target.peaks)


def _cells(plan: CalibrationPlan, search: Search) -> list[list[str]]:
    """The table in words, the heading first."""
    kind = "difference of peaks" if _peaks(plan) else "difference"
    rows = [[plan.axis.label, "restitution", kind]]
    for trial in search.made:
        mark = " *" if search.within_reach and trial is search.best else ""
        value = f"{trial.value:g}{mark}"
        rows.append([value, f"{trial.restitution:.4f}", f"{search.error(trial):.4f}"])
    return rows


def _sentences(plan: CalibrationPlan, search: Search) -> list[str]:
    """What came of it, in words."""
    least, largest = search.reach
    kind = "of the measured peaks" if _peaks(plan) else f"of the first {plan.target.impacts}"
    wanted = f"target: restitution {plan.target.restitution:.4f}, the geometric mean {kind}"
    reach = f"within reach: {_words_of_reach(plan, least, largest)}"
    if not search.within_reach:
        return [f"{wanted}; not {reach}"]
    best = search.best
    unit = f" {plan.axis.unit}" if plan.axis.unit else ""
    found = f"{plan.axis.key} = {best.value:g}{unit}: restitution {best.restitution:.4f}"
    return [wanted, reach, f"{found}, after {len(search.trials)} runs"]


def _markdown(plan: CalibrationPlan, search: Search) -> str:
    """The table for reading."""
    from solver.study.damping.table import markdown

    title = plan.base.scene.title or "Calibration"
    return markdown(title, _cells(plan, search), _sentences(plan, search))


def _tell(plan: CalibrationPlan, search: Search, close: bool) -> None:
    """Print the table, what came of it, and where it is."""
    from solver.study.damping.table import plain_text

    lines = _sentences(plan, search)
    if not close:
        lines.append(f"no run came nearer than {search.best_error:.4f}: impacts scatter")
    say(plain_text(_cells(plan, search), lines))
    say(f"written to {plan.folder}; run {plan.folder / 'calibrated.toml'}\n")
