"""Overlap of two boxes, against closed forms in the plane and in space."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.boxes import Boxes, overlap_depth
from solver.results.motion import rotated

Array = NDArray[np.float64]


def box(half: list[float], centre: list[float], frame: Array | None = None) -> Boxes:
    """A box at one instant."""
    axes = np.eye(len(half)) if frame is None else frame
    return Boxes(half=np.array(half), centres=np.array([centre]), frames=axes[None])


def turned(vector: list[float]) -> Array:
    """The rotation matrix of a rotation vector, rad."""
    return np.stack([rotated(np.array([vector]), axis)[0] for axis in np.eye(3)], axis=1)


def depth(first: Boxes, second: Boxes) -> float:
    """The same whichever box comes first."""
    found = float(overlap_depth(first, second)[0])
    assert found == pytest.approx(float(overlap_depth(second, first)[0]), abs=1e-15)
    return found


@pytest.mark.parametrize("shift", [0.7, 1.0, 1.2])
def test_boxes_along_the_axes(shift: float) -> None:
    """Half widths 0.5 each: they overlap by 1 - shift, and are as far apart where that is < 0."""
    plane = depth(box([0.5, 2.0], [0.0, 0.0]), box([0.5, 1.0], [shift, 0.3]))
    space = depth(box([0.5, 2.0, 3.0], [0.0] * 3), box([0.5, 1.0, 1.0], [shift, 0.3, 1.0]))
    assert plane == pytest.approx(1.0 - shift, abs=1e-15)
    assert space == pytest.approx(1.0 - shift, abs=1e-15)


@pytest.mark.parametrize("angle", [0.1, 0.5, 1.2])
def test_a_corner_of_a_tilted_box_in_a_wall(angle: float) -> None:
    """It reaches a cos + b sin towards the wall, a face that is long beside it."""
    a, b, gap = 0.3, 0.5, 0.4
    cosine, sine = math.cos(angle), math.sin(angle)
    reach = a * cosine + b * sine
    frame = np.array([[cosine, sine], [-sine, cosine]])
    wall, leaning = box([1.0, 9.0], [-1.0, 0.0]), box([a, b], [gap, 0.0], frame)
    assert depth(wall, leaning) == pytest.approx(reach - gap, abs=1e-15)
    wall3 = box([1.0, 9.0, 9.0], [-1.0, 0.0, 0.0])
    leaning3 = box([a, 0.2, b], [gap, 0.1, 0.0], turned([0.0, angle, 0.0]))
    assert depth(wall3, leaning3) == pytest.approx(reach - gap, abs=1e-15)


@pytest.mark.parametrize("distance", [1.2, 1.5])
def test_two_crossing_edges(distance: float) -> None:
    """Bars along x and along y, both on edge (turned by 45 degrees): their edges cross at once.

    Each reaches sqrt(2) a towards the other, and only the normal of the two edges tells it.
    """
    a = 0.5
    along_x = box([5.0, a, a], [0.0, 0.0, 0.0], turned([math.pi / 4, 0.0, 0.0]))
    along_y = box([a, 5.0, a], [0.0, 0.0, distance], turned([0.0, math.pi / 4, 0.0]))
    assert depth(along_x, along_y) == pytest.approx(2 * math.sqrt(2) * a - distance, abs=1e-12)


def test_moving_by_the_depth_parts_them() -> None:
    """Random boxes: along no direction does a shorter way part them, along one the depth does."""
    draw = np.random.default_rng(7)
    ways = draw.normal(size=(400, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    for _ in range(20):
        first = box([0.5, 0.4, 0.3], [0.0] * 3, turned(list(draw.normal(size=3))))
        second_frame = turned(list(draw.normal(size=3)))
        centre = draw.normal(size=3) * 0.3
        deep = depth(first, box([0.2, 0.6, 0.4], list(centre), second_frame))
        assert deep > 0
        moved = [
            float(overlap_depth(first, box([0.2, 0.6, 0.4], list(centre + way), second_frame))[0])
            for way in 0.999 * deep * ways
        ]
        assert min(moved) > 0
