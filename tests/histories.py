"""Histories made up column by column, and their summaries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rockslip import History, Scene, parse_scene
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
