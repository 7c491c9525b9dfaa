"""Histories made up column by column, and their summaries; what is read from those of runs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockslip import History, Result, Scene, parse_scene
from solver.history.events import Event
from solver.history.history import scene_columns
from solver.results.summary import summarise

Array = NDArray[np.float64]

BLOCK = "width = 0.4\nheight = 1.0\nthickness = 0.3\nmass = 100.0\nmodel = 'rigid'\n"
TIME = "[time]\nend = 1.0\nstep = 0.01\n"
OSCILLATOR = "[foundation]\nkind = 'oscillator'\nmass = 50.0\nperiod = 0.5\n"


def scene_of(*blocks: str, dimension: int = 2, rest: str = "") -> Scene:
    """A scene of such blocks, each with some keys of its own."""
    tables = "".join(f"[[block]]\n{BLOCK}{keys}\n" for keys in blocks)
    return parse_scene(f"dimension = {dimension}\n{tables}{rest}\n{TIME}")


def history_of(scene: Scene, time: Array, **values: Any) -> History:
    """A history of these columns (a double underscore for the dot), the others zero."""
    given = {name.replace("__", "."): value for name, value in values.items()}
    history = History(scene_columns(scene))
    assert set(given) <= set(history.columns)
    step = np.gradient(time)
    table = [given.get(name, 0.0) + 0.0 * time for name in history.columns]
    table[0], table[1] = time, step
    history.extend(np.stack(table, axis=1))
    return history


def summary_of(scene: Scene, history: History) -> dict[str, Any]:
    return summarise(scene, history, status="completed", cost={}, versions={})


def events(result: Result, kind: str) -> list[Event]:
    """The events of a kind of a run."""
    assert result.history.events is not None
    return [event for event in result.history.events if event.kind == kind]


def lift_off(time: Array, angle: Array, after: float, before: float) -> float:
    """When a block lifted whose angle grows with the cube of the time since then, s."""
    rows = np.flatnonzero((np.abs(angle) > after) & (np.abs(angle) < before))
    line = np.polynomial.Polynomial.fit(time[rows], np.cbrt(np.abs(angle[rows])), 1)
    return float(line.roots()[0])
