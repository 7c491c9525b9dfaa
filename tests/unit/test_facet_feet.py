"""ClosestPoints of points on a face whose facets have been drawn out of their shape, in space."""

from __future__ import annotations

import numpy as np
import pytest

from solver.contact.body_points import FixedPoints, PointState
from solver.contact.carriers import Face

COUNT = 6
"""Facets along a side of the face, 1 m each."""

FARTHER = 0.5
"""Part of a facet: one that is farther than the nearest one by more is not tried (facets.hpp)."""

FRAME = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@pytest.mark.parametrize(("seed", "moved"), [(1, 0.14), (2, 0.16), (3, 0.15), (7, 0.15)])
def test_a_point_is_found_on_its_facet(seed: int, moved: float) -> None:
    """Taken as spanned by two edges, a facet misses points that are on it.

    It does so by no more than its last corner is off the parallelogram of the others. Here that is
    up to 0.47 to 0.49 of a facet: where less than 0.4 were allowed, points would stand on the
    facets beside theirs.
    """
    steps = np.arange(COUNT + 1.0)
    undeformed = np.array([(x, y, 0.0) for y in steps for x in steps])
    number = np.arange(len(undeformed)).reshape(COUNT + 1, -1)
    corners = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    facets = np.stack(corners, axis=-1).reshape(-1, 4)
    nodes = undeformed.copy()
    nodes[:, :2] += np.random.default_rng(seed).uniform(-moved, moved, (len(nodes), 2))

    first, along, across, last = np.moveaxis(nodes[facets, :2], 1, 0)
    edges = np.stack([along - first, across - first], axis=-1)
    off = np.linalg.solve(edges, (first + last - along - across)[..., None])
    assert 0.4 < np.abs(off).max() < FARTHER

    x, y = np.stack(np.meshgrid((0.02, 0.5, 0.98), (0.02, 0.5, 0.98)), axis=-1).reshape(-1, 2).T
    weights = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=-1)
    here, there = (
        np.einsum("pk,fkd->fpd", weights, each[facets]).reshape(-1, 3)
        for each in (nodes, undeformed)
    )
    face = Face(FixedPoints(undeformed), facets, FRAME, "quadrilateral")
    found = face.kinematics(here, PointState(nodes), FRAME)
    np.testing.assert_allclose(found.place[:, 1:], there[:, :2], atol=1e-12)
    assert not np.any(face.beyond_edge(found))
