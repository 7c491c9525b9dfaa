"""What was saved on some ranks, taken over by others: each node keeps its digits."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import BLOCK, OSCILLATOR, UPPER

pytest.importorskip("dolfinx")

from mpi4py import MPI

from rockslip import parse_scene
from solver.bodies.elastic_body import ElasticBody
from solver.build.assembly import build
from solver.errors import SceneError
from solver.run.redistribution import (
    Owned,
    Redistribution,
    owned_by_rank,
    redistributed,
    refuse_other_places,
)
from solver.stepping.local_error import Past
from solver.stepping.state import State
from solver.stepping.system import System
from solver.types import Array

pytestmark = pytest.mark.serial

SCENE = f"""
{BLOCK}
cells = [3, 4]
{UPPER}
{OSCILLATOR}
[time]
end = 0.1
step = 0.001
"""

RANKS = 3


@pytest.fixture(scope="module")
def system() -> System:
    """A meshed block, a rigid one and a platform, on one rank."""
    return build(parse_scene(SCENE), comm=MPI.COMM_SELF).stepper.system


class Before:
    """The same bodies on three ranks that own their nodes in any order; some own none."""

    def __init__(self, system: System):
        chance = np.random.default_rng(5)
        self.system = system
        self.nodes: list[list[Array]] = []
        for body in system.bodies:
            count = len(body.nodes) if isinstance(body, ElasticBody) else 0
            ends = sorted(chance.integers(0, count + 1, RANKS - 2))
            self.nodes.append([*np.split(chance.permutation(count), ends), np.empty(0, int)])

    def owned(self) -> list[list[Owned]]:
        """What each rank owns of each body."""
        return [
            [self._owned(number, rank) for number in range(len(self.system.bodies))]
            for rank in range(RANKS)
        ]

    def _owned(self, number: int, rank: int) -> Owned:
        body, nodes = self.system.bodies[number], self.nodes[number][rank]
        if isinstance(body, ElasticBody):
            return Owned(2 * len(nodes), body.nodes[nodes])
        return Owned(body.unknowns if rank == 0 else 0, np.empty((0, 2)))

    def body(self, number: int, vector: Array) -> list[Array]:
        """A vector of a body, rank by rank."""
        if isinstance(self.system.bodies[number], ElasticBody):
            rows = vector.reshape(-1, 2)
            return [rows[nodes].ravel() for nodes in self.nodes[number]]
        return [vector, *[np.empty(0)] * (RANKS - 1)]

    def whole(self, vector: Array) -> list[Array]:
        """A vector of all bodies, rank by rank."""
        parts = [self.body(number, vector[own]) for number, own in enumerate(self.system.slices)]
        return [np.concatenate(rank) for rank in zip(*parts, strict=True)]


def test_vectors_keep_their_digits(system: System) -> None:
    before = Before(system)
    moved = Redistribution(system, before.owned())
    vector = np.random.default_rng(6).normal(size=system.size)
    assert np.array_equal(moved.system(before.whole(vector)), vector)
    for number, own in enumerate(system.slices):
        parts = before.body(number, vector[own])
        assert np.array_equal(moved.body(number, parts), vector[own])


def test_all_that_ranks_hold_apart_is_moved(system: System) -> None:
    """State, strains and the past of the judge; all else is that of the first rank."""
    before, chance = Before(system), np.random.default_rng(7)
    fields = {name: chance.normal(size=system.size) for name in ("u", "v", "p", "held")}
    past = {name: chance.normal(size=system.size) for name in ("u", "mean", "change")}
    solve, strained = chance.normal(size=system.size), chance.normal(size=system.slices[0].stop)
    rigid = np.arange(3.0)
    parts = [
        {
            "owned": owned,
            "state": State(
                time=0.5,
                contacts=(),
                motions={},
                **{name: before.whole(vector)[rank] for name, vector in fields.items()},
            ),
            "judge": (
                Past(
                    rigid=rigid,
                    rigid_change=rigid,
                    **{name: before.whole(vector)[rank] for name, vector in past.items()},
                ),
                0.25,
            ),
            "stepper": {
                "strained": [before.body(0, strained)[rank], None, None],
                "solve": {"strained_at": before.whole(solve)[rank], "counts": (3, 1)},
            },
            "counts": (8, 2, 16),
        }
        for rank, owned in enumerate(before.owned())
    ]
    found = redistributed(system, parts)
    for name, vector in fields.items():
        assert np.array_equal(getattr(found["state"], name), vector)
    for name, vector in past.items():
        assert np.array_equal(getattr(found["judge"][0], name), vector)
    assert np.array_equal(found["stepper"]["strained"][0], strained)
    assert np.array_equal(found["stepper"]["solve"]["strained_at"], solve)
    assert found["stepper"]["solve"]["counts"] == (3, 1)
    assert (found["state"].time, found["judge"][1], found["counts"]) == (0.5, 0.25, (8, 2, 16))
    refuse_other_places(system, found["owned"])


def test_another_mesh_is_refused(system: System) -> None:
    before = Before(system)
    owned = before.owned()
    meshed = next(k for k, body in enumerate(system.bodies) if isinstance(body, ElasticBody))
    elsewhere = [list(rank) for rank in owned]
    elsewhere[0][meshed] = owned[0][meshed]._replace(places=owned[0][meshed].places + 1e-4)
    fewer = [list(rank) for rank in owned]
    fewer[0][meshed] = Owned(
        owned[0][meshed].size - 2, np.delete(owned[0][meshed].places, 0, axis=0)
    )
    for other in (elsewhere, fewer):
        with pytest.raises(SceneError, match="a checkpoint of another mesh"):
            Redistribution(system, other)
    with pytest.raises(SceneError, match="a checkpoint of another mesh"):
        refuse_other_places(system, elsewhere[0])
    refuse_other_places(system, owned_by_rank(system))
