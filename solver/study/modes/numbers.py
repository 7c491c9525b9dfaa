"""Numbers of a study of modes: every point beside Shenton's criteria and closed forms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from geometry.block import Block
from solver.reference.initiation import initial_accelerations, initial_mode, near_boundary
from solver.study.tables import groups, in_columns

Row = dict[str, Any]

BAND = 0.03
"""Points whose mode changes with mu and A within this part of themselves are not judged."""

NAMES = (
    *("engine", "ratio", "acceleration_g", "friction", "mode", "expected", "judged", "agrees"),
    *("turn_rad_s2", "expected_turn_rad_s2", "slip_m_s2", "expected_slip_m_s2"),
    *("rigid_turn_rad_s2", "rigid_slip_m_s2"),
)
"""Columns of the table."""


def points_of(rows: Sequence[Mapping[str, Any]], gravity: float) -> list[Row]:
    """One row for each point of the rows of completed cases; gravity g in m/s^2."""
    return [_point(row, point, gravity) for row in rows for point in row["points"]]


def _point(row: Mapping[str, Any], point: Mapping[str, Any], gravity: float) -> Row:
    """A point beside what is expected of it."""
    width = row["width"]
    ratio, a, mu = row["ratio"], row["acceleration"], point["friction"]
    shape = Block(width=width, height=ratio * width, thickness=1.0, density=1.0)
    turn, slip = initial_accelerations(a, mu, shape, gravity)
    expected = initial_mode(a, mu, ratio)
    return {
        "engine": row["engine"],
        "ratio": ratio,
        "acceleration_g": a,
        "friction": mu,
        "mode": point["mode"],
        "expected": expected,
        "judged": not near_boundary(a, mu, ratio, BAND),
        "agrees": point["mode"] == expected,
        "turn_rad_s2": point["turn"],
        "expected_turn_rad_s2": turn,
        "slip_m_s2": point["slip"],
        "expected_slip_m_s2": slip,
        "rigid_turn_rad_s2": point.get("rigid_turn", point["turn"]),
        "rigid_slip_m_s2": point.get("rigid_slip", point["slip"]),
    }


def maps_of(points: Sequence[Row]) -> list[Row]:
    """Agreement and largest errors of the accelerations of each map (engine, H/B).

    Errors are those of judged points in the right mode: relative, and where a block slides and
    rocks the slip's in m/s^2, since it is a small difference of large numbers. Those of an elastic
    block are also given against a rigid one under the same ramp, which turns meanwhile as it does.
    """
    maps = groups(points, lambda point: (point["engine"], point["ratio"]))
    return [_map(inside) for inside in maps.values()]


def _map(points: Sequence[Row]) -> Row:
    """Agreement and errors of one map."""
    judged = [point for point in points if point["judged"]]
    right = [point for point in judged if point["agrees"]]
    found: Row = {
        "engine": points[0]["engine"],
        "ratio": points[0]["ratio"],
        "points": len(points),
        "judged": len(judged),
        "agree": len(right),
    }
    for what in ("expected", "rigid"):
        found |= {
            f"{what}_slide_slip": _worst(right, "slide", "slip_m_s2", what),
            f"{what}_rock_turn": _worst(right, "rock", "turn_rad_s2", what),
            f"{what}_slide_rock_turn": _worst(right, "slide-rock", "turn_rad_s2", what),
            f"{what}_slide_rock_slip_m_s2": max(
                (
                    abs(point["slip_m_s2"] - point[f"{what}_slip_m_s2"])
                    for point in right
                    if point["mode"] == "slide-rock"
                ),
                default=None,
            ),
        }
    return found


def _worst(points: Sequence[Row], mode: str, key: str, what: str) -> float | None:
    """Largest relative error of a number over the points in a mode; None without one."""
    errors = [abs(p[key] / p[f"{what}_{key}"] - 1) for p in points if p["mode"] == mode]
    return max(errors, default=None)


def as_text(maps: Sequence[Row]) -> str:
    """The maps as text."""
    heading = ("engine", "H/B", "points", "judged", "agree", "errors against")
    errors = ("slide s''", "rock theta''", "slide-rock theta''", "slide-rock s'' m/s2")
    table: list[Sequence[str]] = [heading + errors]
    for found in maps:
        counts = [str(found[key]) for key in ("points", "judged", "agree")]
        for what, words in (("expected", "closed forms"), ("rigid", "rigid, same ramp")):
            if what == "rigid" and found["engine"] == "rigid":
                continue
            keys = (f"{what}_{name}" for name in ("slide_slip", "rock_turn", "slide_rock_turn"))
            cells = ["-" if (e := found[key]) is None else f"{100 * e:.3f} %" for key in keys]
            slip = found[f"{what}_slide_rock_slip_m_s2"]
            last = "-" if slip is None else f"{slip:.4f}"
            table.append([found["engine"], f"{found['ratio']:g}", *counts, words, *cells, last])
    return "\n".join(in_columns(table)) + "\n"
