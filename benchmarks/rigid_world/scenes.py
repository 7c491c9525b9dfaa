"""Scenes of rigid bodies that meet each other: walls, yard, dominoes, cubes, trilith."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from rockslip import Scene
from solver.rigid.system import RigidSystem

Tables = dict[str, Any]

G = 9.81


def wall(
    columns: int,
    courses: int,
    *,
    joint: float = 0.002,
    brick: tuple[float, float] = (0.4, 0.2),
    friction: float = 0.6,
    **tables: Any,
) -> Tables:
    """A wall in running bond; halves close the ends of every other course.

    Args:
        columns: Whole bricks in the lowest course.
        courses: How many, each with its own height.
        joint: Between neighbours in a course, m.
        brick: Width and height, m.
        friction: Of all joints.
        tables: Further tables of the scene.
    """
    width, height = brick
    bricks = [
        {
            "name": f"c{course}b{number}",
            "model": "rigid",
            "width": wide,
            "height": height,
            "density": 2000.0,
            "position": [x, height * (course + 0.5)],
        }
        for course in range(courses)
        for number, (x, wide) in enumerate(_course(course, columns, width, joint))
    ]
    return {"block": bricks, "contact": {"friction": friction}, "time": {"end": 1.0}} | tables


def _course(course: int, columns: int, width: float, joint: float) -> Iterator[tuple[float, float]]:
    """Middle and width of each brick of a course."""
    pitch, first = width + joint, -(columns - 1) / 2 * (width + joint)
    if course % 2 == 0:
        yield from ((first + k * pitch, width) for k in range(columns))
        return
    half = (width - joint) / 2
    end = -first + (width - half) / 2
    yield -end, half
    yield from ((first + (k + 0.5) * pitch, width) for k in range(columns - 1))
    yield end, half


def dominoes(d: int = 2, step: float = 1e-3) -> Tables:
    """Five of 0.1 m x 1 m every 0.4 m, the first one tilted by 8 degrees."""
    size = {"model": "rigid", "width": 0.1, "height": 1.0, "mass": 50.0}
    blocks = [size | {"name": f"n{k + 1}", "offset": 0.4 * k} for k in range(5)]
    blocks[0]["tilt_deg"] = 8.0
    time = {"end": 1.8, "step": step}
    return {"dimension": d, "block": blocks, "contact": {"friction": 0.5}, "time": time}


def yard(rows: int = 4, lines: int = 3, levels: int = 3, **tables: Any) -> Tables:
    """Full containers in space, 0.4 m apart, in stacks."""
    width, length, height = 2.44, 6.06, 2.59
    boxes = [
        {
            "name": f"x{i}y{j}z{k}",
            "model": "rigid",
            "width": width,
            "thickness": length,
            "height": height,
            "mass": 10000.0,
            "on": f"x{i}y{j}z{k - 1}" if k else "foundation",
        }
        | ({} if k else {"offset": i * (width + 0.4), "offset_second": j * (length + 0.4)})
        for i in range(rows)
        for j in range(lines)
        for k in range(levels)
    ]
    scene = {"dimension": 3, "block": boxes, "contact": {"friction": 0.4}, "time": {"end": 5.0}}
    return scene | tables


def apart(count: int, d: int = 2, **tables: Any) -> Tables:
    """Blocks that stand tilted by three degrees, too far from each other to meet."""
    size = {"model": "rigid", "width": 0.25, "height": 1.0, "thickness": 0.75, "mass": 503.0}
    blocks = [size | {"name": f"n{k}", "offset": 5.0 * k, "tilt_deg": 3.0} for k in range(count)]
    scene = {"dimension": d, "block": blocks, "contact": {"friction": 0.7}, "time": {"end": 3.0}}
    return scene | tables


def trilith(
    *,
    column: tuple[float, float] = (0.5, 2.0),
    lintel: tuple[float, float] = (3.0, 0.4),
    span: float = 2.0,
    friction: float = 0.75,
    **tables: Any,
) -> Tables:
    """Two columns and a lintel of one density; widths and heights, distance of the axes, m."""
    sizes = {"left": column, "right": column, "lintel": lintel}
    blocks: list[Tables] = [
        {"name": name, "model": "rigid", "width": width, "height": height, "density": 2400.0}
        for name, (width, height) in sizes.items()
    ]
    for block, more in zip(
        blocks,
        ({"offset": -span / 2}, {"offset": span / 2}, {"on": ["left", "right"]}),
        strict=True,
    ):
        block |= more
    return {"block": blocks, "contact": {"friction": friction}, "time": {"end": 4.0}} | tables


def cubes(seed: int, count: int = 10, size: float = 0.5) -> Tables:
    """A column of cubes in space with random offsets; `turned` turns them about the vertical."""
    random = np.random.default_rng(seed)
    blocks = [
        {
            "name": f"cube{k}",
            "model": "rigid",
            **dict.fromkeys(("width", "thickness", "height"), size),
            "density": 2000.0,
            "position": [*random.uniform(-0.1 * size, 0.1 * size, 2), size * (k + 0.5)],
        }
        for k in range(count)
    ]
    return {"dimension": 3, "block": blocks, "contact": {"friction": 0.6}, "time": {"end": 8.0}}


def weight(block: Tables) -> float:
    """Weight of a block by its table, N."""
    volume = block["width"] * block["height"] * block.get("thickness", 1.0)
    return G * float(block["mass"] if "mass" in block else block["density"] * volume)


def turned(scene: Scene, seed: int, most: float = 0.3) -> RigidSystem:
    """The system of a scene in space on the ground, each block turned by up to `most`, rad."""
    random, poses = np.random.default_rng(seed), scene.poses()
    for block in scene.blocks:
        angle = random.uniform(-most, most)
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        poses[block.name] = replace(poses[block.name], rotation=turn)
    return RigidSystem(scene, poses)
