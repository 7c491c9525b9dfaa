"""A saved run on another number of ranks: its vectors go to the ranks that own their nodes now.

Contact, compliances and all that is decided by them stand in an order that no partition changes,
the same on every rank. Only vectors of the owned unknowns differ: a node is found again by its
place in the undeformed mesh, and its digits stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import KDTree

from solver.bodies.elastic_body import ElasticBody
from solver.errors import SceneError
from solver.parallel import any_rank
from solver.stepping.local_error import Past
from solver.stepping.state import State
from solver.stepping.system import Body, System
from solver.types import Array, Indices

SAME_PLACE = 1e-9
"""Part of a body's size within which two places are one."""

HELD_APART = ("u", "v", "p", "held")
"""Fields of a state that are vectors of the owned unknowns."""

PAST_APART = ("u", "mean", "change")
"""Fields of the past that errors of steps are judged by, which are such vectors."""


class Owned(NamedTuple):
    """What a rank owns of a body."""

    size: int
    """Number of unknowns."""
    places: Array
    """Where its nodes are in the undeformed mesh, (nodes, d), m; none of a rigid body."""


def owned_by_rank(system: System) -> list[Owned]:
    """What this rank owns of each body."""
    none = np.empty((0, system.dimension))
    return [
        Owned(body.size, body.nodes if isinstance(body, ElasticBody) else none)
        for body in system.bodies
    ]


def refuse_other_places(system: System, saved: Sequence[Owned]) -> None:
    """Refuse what was saved on as many ranks for nodes that stand elsewhere; collective.

    Raises:
        SceneError: Gmsh or the partition is not that of the checkpoint.
    """
    here = owned_by_rank(system)
    elsewhere = any(
        old.size != new.size or not np.array_equal(old.places, new.places)
        for old, new in zip(saved, here, strict=True)
    )
    _refuse(system, elsewhere)


def _refuse(system: System, elsewhere: bool) -> None:
    """Refuse a checkpoint on all ranks where one of them finds nodes elsewhere."""
    if any_rank(system.comm, elsewhere):
        raise SceneError("--resume", "a checkpoint of another mesh", "that of this run")


class Redistribution:
    """Which of the unknowns that the ranks of then owned this rank owns now."""

    def __init__(self, system: System, before: Sequence[Sequence[Owned]]):
        """Find the nodes of this rank among those `before`, by rank and body; collective.

        Raises:
            SceneError: They are not there: the mesh is another one.
        """
        self._ends = [np.cumsum([own.size for own in rank])[:-1] for rank in before]
        found = [
            _rows(body, [own.places for own in owned])
            for body, owned in zip(system.bodies, zip(*before, strict=True), strict=True)
        ]
        _refuse(system, any(rows is None for rows in found))
        self._rows = [rows for rows in found if rows is not None]

    def body(self, number: int, vectors: Sequence[Array]) -> Array:
        """The part of this rank of a vector of a body, from those of all ranks of then."""
        return np.concatenate(vectors)[self._rows[number]]

    def system(self, vectors: Sequence[Array]) -> Array:
        """The part of this rank of a vector of all bodies."""
        pieces = [np.split(vector, ends) for vector, ends in zip(vectors, self._ends, strict=True)]
        bodies = enumerate(zip(*pieces, strict=True))
        return np.concatenate([self.body(number, piece) for number, piece in bodies])

    def fields(self, saved: Sequence[Any], names: Sequence[str]) -> dict[str, Any]:
        """Vectors of these names as they are on this rank, from what all ranks of then saved."""
        vectors = {name: [getattr(one, name) for one in saved] for name in names}
        return {name: self.system(own) for name, own in vectors.items()}


def _rows(body: Body, places: Sequence[Array]) -> Indices | None:
    """Where the unknowns that this rank owns stood among those of a body; None: some did not."""
    if not isinstance(body, ElasticBody):
        return np.arange(body.size)  # rank 0 has all of them
    before = np.concatenate(places)
    if before.size != body.unknowns:
        return None
    distance, node = KDTree(before).query(body.nodes)
    if np.any(distance > SAME_PLACE * np.ptp(before, axis=0).max()):
        return None
    rows: Indices = (node[:, None] * body.dimension + np.arange(body.dimension)).ravel()
    return rows


def redistributed(system: System, parts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What this rank would have saved, from what all ranks of then did; collective.

    Raises:
        SceneError: It was another mesh.
    """
    moved, first = Redistribution(system, [part["owned"] for part in parts]), parts[0]
    apart = moved.fields([part["state"] for part in parts], HELD_APART)
    state: State = first["state"]._replace(**apart)
    judge = first["judge"]
    if judge is not None:
        past: Past = judge[0]
        judge = (
            past._replace(**moved.fields([part["judge"][0] for part in parts], PAST_APART)),
            judge[1],
        )
    steppers = [part["stepper"] for part in parts]
    solve = dict(steppers[0]["solve"])
    if solve["strained_at"] is not None:
        solve["strained_at"] = moved.system([each["solve"]["strained_at"] for each in steppers])
    strained = [
        None if one is None else moved.body(number, [each["strained"][number] for each in steppers])
        for number, one in enumerate(steppers[0]["strained"])
    ]
    stepper = steppers[0] | {"solve": solve, "strained": strained}
    return first | {
        "owned": owned_by_rank(system),
        "state": state,
        "judge": judge,
        "stepper": stepper,
    }
