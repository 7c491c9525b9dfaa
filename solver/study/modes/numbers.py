"""Numbers of a study of modes: every point beside Shenton's criteria and closed forms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from geometry.block import Block
from solver.reference.initiation import initial_accelerations, initial_mode, near_boundary
from solver.study.tables import Column, groups, in_columns, in_words

Row = dict[str, Any]

BAND = 0.03
"""Points whose mode changes with mu and A within this part of themselves are not judged."""

NAMES = (
    *("engine", "ratio", "acceleration_g", "friction", "mode", "expected", "judged", "agrees"),
    *("turn_rad_s2", "expected_turn_rad_s2", "slip_m_s2", "expected_slip_m_s2"),
    *("rigid_turn_rad_s2", "rigid_slip_m_s2"),
)
"""Columns of the table."""

ERRORS = (
    ("slide", "slip_m_s2", "slide_slip"),
    ("rock", "turn_rad_s2", "rock_turn"),
    ("slide-rock", "turn_rad_s2", "slide_rock_turn"),
    ("slide-rock", "slip_m_s2", "slide_rock_slip_m_s2"),
)
"""Mode, number and name of the errors of a map; that in m/s^2 is not relative."""

COLUMNS = (
    *(Column("engine", "engine"), Column("ratio", "H/B", "g"), Column("points", "points")),
    *(Column("judged", "judged"), Column("agree", "agree"), Column("against", "errors against")),
    *(Column("slide_slip", "slide s''", ".3%"), Column("rock_turn", "rock theta''", ".3%")),
    Column("slide_rock_turn", "slide-rock theta''", ".3%"),
    Column("slide_rock_slip_m_s2", "slide-rock s'' m/s2", ".4f"),
)
"""Those of the text."""


def points_of(rows: Sequence[Mapping[str, Any]], gravity: float) -> list[Row]:
    """One row for each point of the rows of completed cases; gravity g in m/s^2."""
    return [_point(row, point, gravity) for row in rows for point in row["points"]]


def _point(row: Mapping[str, Any], point: Mapping[str, Any], gravity: float) -> Row:
    """A point beside what is expected of it."""
    width, ratio, a, mu = row["width"], row["ratio"], row["acceleration_g"], point["friction"]
    shape = Block(width=width, height=ratio * width, thickness=1.0, density=1.0)
    turn, slip = initial_accelerations(a, mu, shape, gravity)
    expected = initial_mode(a, mu, ratio)
    return {
        **{name: row[name] for name in ("engine", "ratio", "acceleration_g")},
        "expected": expected,
        "judged": not near_boundary(a, mu, ratio, BAND),
        "agrees": point["mode"] == expected,
        "expected_turn_rad_s2": turn,
        "expected_slip_m_s2": slip,
        "rigid_turn_rad_s2": point["turn_rad_s2"],
        "rigid_slip_m_s2": point["slip_m_s2"],
        **point,
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
        for mode, key, name in ERRORS:
            own = [(p[key], p[f"{what}_{key}"]) for p in right if p["mode"] == mode]
            relative = name != "slide_rock_slip_m_s2"
            errors = (abs(value / to - 1) if relative else abs(value - to) for value, to in own)
            found[f"{what}_{name}"] = max(errors, default=None)
    return found


def as_text(maps: Sequence[Row]) -> str:
    """The maps as text."""
    against = {"expected": "closed forms", "rigid": "rigid, same ramp"}
    rows = [
        found | {"against": words} | {name: found[f"{what}_{name}"] for *_, name in ERRORS}
        for found in maps
        for what, words in against.items()
        if what != "rigid" or found["engine"] != "rigid"
    ]
    return "\n".join(in_columns(in_words(rows, COLUMNS))) + "\n"
