"""Faces of bodies in space: what is nearer to the eye is drawn over what is behind."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.path import Path
from scipy.spatial.transform import Rotation

from solver.pictures.deformed import seen_from_front
from solver.pictures.drawing_order import drawing_order
from solver.types import Array

Turn = tuple[float, float, float]


def box(size: Any, centre: Any, pieces: int, turn: Turn = (0.0, 0.0, 0.0)) -> list[Array]:
    """The faces of a box, each in so many pieces along both sides, turned about its centre."""
    found = []
    ends = np.linspace(-0.5, 0.5, pieces + 1)
    for axis in range(3):
        for side in (-0.5, 0.5):
            for a0, a1 in pairwise(ends):
                for b0, b1 in pairwise(ends):
                    ring = np.array([(a0, b0), (a1, b0), (a1, b1), (a0, b1)])
                    face = np.insert(ring, axis, side, axis=1) * size
                    found.append(Rotation.from_rotvec(turn).apply(face) + centre)
    return found


WIDE_LID = [
    box((0.4, 0.4, 1.0), (0.0, 0.0, 0.5), 8),
    box((0.9, 0.9, 0.15), (0.0, 0.0, 1.075), 1),
]
SCENES = {
    "a wide lid on a meshed column": WIDE_LID,
    "a lid that overhangs to the left": [
        WIDE_LID[0],
        box((0.9, 0.6, 0.15), (-0.2, 0.0, 1.075), 1),
    ],
    "a lid that leans on an edge": [
        WIDE_LID[0],
        box((0.9, 0.9, 0.15), (0.0, 0.0, 1.16), 1, (0.0, 0.2, 0.0)),
    ],
    "a small block on a wide plate of one piece": [
        box((3.0, 2.0, 0.3), (0.0, 0.0, -0.15), 1),
        box((0.3, 0.3, 0.9), (-0.9, 0.6, 0.45), 5),
    ],
    "two blocks side by side on a meshed plate, a lid over one": [
        box((3.0, 2.0, 0.3), (0.0, 0.0, -0.15), 6),
        box((0.5, 0.5, 1.0), (-0.5, 0.2, 0.5), 1, (0.0, 0.0, 0.4)),
        box((0.5, 0.5, 1.0), (0.5, -0.3, 0.5), 5),
        box((0.8, 0.8, 0.2), (0.6, -0.3, 1.1), 1),
    ],
}


def nearest(faces: list[Array], place: Array) -> int:
    """The face that a ray from the eye meets first at a place of the picture; -1: none."""
    best, number = -np.inf, -1
    for k, face in enumerate(faces):
        if Path(face[:, :2]).contains_point(place):
            normal = np.cross(face[1] - face[0], face[2] - face[0])
            if abs(normal[2]) > 1e-9 * np.linalg.norm(normal):
                across = normal[:2] @ (place - face[0, :2])
                depth = face[0, 2] - across / normal[2]
                if depth > best:
                    best, number = float(depth), k
    return number


@pytest.mark.parametrize("name", list(SCENES))
@pytest.mark.parametrize("backwards", [False, True])
def test_nearer_faces_are_drawn_over_those_behind(name: str, backwards: bool) -> None:
    """At places all over the picture, whatever the order of the bodies in the files."""
    bodies = SCENES[name][::-1] if backwards else SCENES[name]
    faces = [seen_from_front(face) for body in bodies for face in body]
    order = drawing_order(faces, np.repeat(np.arange(len(bodies)), [len(b) for b in bodies]))
    assert sorted(order) == list(range(len(faces)))
    outlines = np.concatenate(faces)[:, :2]
    places = np.random.default_rng(3).uniform(outlines.min(axis=0), outlines.max(axis=0), (300, 2))
    shown = [
        next((k for k in order[::-1] if Path(faces[k][:, :2]).contains_point(place)), -1)
        for place in places
    ]
    assert shown == [nearest(faces, place) for place in places]
