"""Random scenes of rigid blocks with shapes, feet, uneven mass, links and forces.

    ./in-env python3 -m benchmarks.shapes [COUNT] [FIRST SEED]

One to four blocks in the plane or in space, on ground or on a spring, under a pulse or a force,
tied by links that yield or break. Each has a verdict as in the stability study: no step may fail,
no energy may be gained, and the ledger has to close. Writes a line for each that is refused or
fails, and the worst numbers. It takes a minute.
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.stability.matrix import StabilityCase
from benchmarks.stability.run import judged
from benchmarks.stability.table import as_text
from solver.study.scenes import Tables

LIMIT = 120.0
"""Wall time of a scene, s."""


def case(seed: int) -> StabilityCase:
    """The scene of a seed, to be judged."""
    return StabilityCase(family="shapes", row=str(seed), column="", tables=random_scene(seed))


def random_scene(seed: int) -> Tables:
    """The tables of a scene."""
    random = np.random.default_rng(seed)
    d = int(random.choice([2, 3]))
    blocks: list[Tables] = []
    for number in range(int(random.integers(1, 5))):
        block = _block(random, d, f"b{number}")
        on = "foundation" if not number or random.random() < 0.4 else f"b{number - 1}"
        block["on"] = on
        if on == "foundation":
            block["offset"] = 3.0 * number
        blocks.append(block)
    scene: Tables = {
        "dimension": d,
        "block": blocks,
        "time": {"end": 2.0, "step": float(random.choice([1e-3, 4e-3]))},
        "contact": {"friction": float(random.uniform(0.1, 1.5))},
        "output": {"fields": "none"},
    }
    if random.random() < 0.3:
        scene["foundation"] = {
            "kind": "oscillator",
            "mass": float(random.uniform(200.0, 5000.0)),
            "period": float(random.uniform(0.2, 1.5)),
            "damping_ratio": float(random.uniform(0.0, 0.1)),
        }
    if random.random() < 0.7:
        pulse = {"kind": "sine", "cycles": 3}
        scene["motion"] = pulse | {
            "amplitude_g": float(random.uniform(0.1, 1.5)),
            "period": float(random.uniform(0.1, 1.0)),
        }
    links = [_link(random, d, blocks, k) for k in range(int(random.integers(0, 3)))]
    if links:
        scene["link"] = links
    if random.random() < 0.4:
        push = random.normal(size=d) * 500.0
        scene["force"] = [{"name": "push", "on": "b0", "force": push.tolist(), "ramp": [0.0, 0.5]}]
    return scene


def _block(random: np.random.Generator, d: int, name: str) -> Tables:
    """A block of any kind; heights and widths between 0.2 and 1.5 m."""
    width, height = map(float, random.uniform([0.2, 0.3], [0.8, 1.5]))
    block: Tables = {"name": name, "model": "rigid", "density": float(random.uniform(500, 8000))}
    block["friction"] = float(random.uniform(0.1, 1.5))
    kinds = ["box", "feet", "uneven", "polygon", "regular", "union"]
    kind = str(random.choice(kinds + (["cylinder", "profile", "vase", "tube"] if d == 3 else [])))
    if d == 3:
        block["thickness"] = float(random.uniform(0.2, 0.8))
    if kind in ("box", "feet", "uneven"):
        block |= {"width": width, "height": height}
    if kind == "feet":
        size = 0.2 * min(width, block.get("thickness", 1.0))
        block["feet"] = {"size": size, "height": float(random.uniform(0.02, 0.2))}
    if kind == "uneven":
        off = float(random.uniform(-0.1, 0.1)) * width
        block["centre_of_mass"] = [off, *[0.0] * (d - 2), 0.5 * height]
    if kind == "polygon":
        angles = np.sort(random.uniform(0, 2 * np.pi, int(random.integers(3, 8))))
        ring = np.stack([width * np.cos(angles), height * np.sin(angles)], axis=1)
        low = np.array([[-0.3 * width, -height], [0.3 * width, -height]])
        ring[:, 1] = np.maximum(ring[:, 1], -0.9 * height)
        block["shape"] = {"polygon": [*low.tolist(), *ring[_rightwards(ring)].tolist()]}
    if kind == "regular":
        block |= {"shape": {"regular": int(random.integers(3, 13))}, "width": width}
    if kind == "union":
        step = 0.3 * height
        feet = [[-width, 0], [width, 0], [width, step], [-width, step]]
        post = [[-0.3 * width, step], [0.3 * width, step], [0.2 * width, height], [0, height]]
        block["shape"] = {"union": [{"polygon": feet}, {"polygon": post}]}
    if kind == "cylinder":
        block |= {"shape": {"cylinder": width, "sides": 16}, "height": height}
    if kind == "profile":
        outline = [[0, 0], [width, 0], [0.4 * width, 0.5 * height], [0.8 * width, height]]
        block["shape"] = {"profile": [*outline, [0, height]], "sides": 12}
    if kind == "vase":  # a neck, a rim, and a wall around what is empty
        outside = np.array([[0, 0], [0.6, 0], [1, 0.4], [0.3, 0.7], [0.5, 1]])
        within = np.array([[0.42, 1], [0.22, 0.7], [0.9, 0.4], [0.5, 0.05], [0, 0.05]])
        wall = np.concatenate([outside, within]) * [0.5 * width, height]
        block["shape"] = {"profile": wall.tolist(), "sides": 12}
    if kind == "tube":
        inner, outer = 0.5 * width * float(random.uniform(0.3, 0.9)), 0.5 * width
        ring = [[inner, 0], [outer, 0], [outer, height], [inner, height]]
        block["shape"] = {"profile": ring, "sides": 16}
    if kind in ("cylinder", "profile", "vase", "tube"):
        block.pop("thickness", None)
    if random.random() < 0.4:
        block["tilt_deg"] = float(random.uniform(-10, 10))
    return block


def _rightwards(ring: np.ndarray) -> np.ndarray:
    """The order of points around the middle of a polygon, from the bottom by the right."""
    turned = np.arctan2(ring[:, 0], -ring[:, 1])  # from straight down towards +x
    return np.asarray(np.argsort(np.where(turned < 0, turned + 2 * np.pi, turned)))


def _link(random: np.random.Generator, d: int, blocks: list[Tables], number: int) -> Tables:
    """A link of a block to the ground, or to another block."""
    names = [block["name"] for block in blocks]
    first = str(random.choice(names))
    others = [name for name in names if name != first]
    second = str(random.choice(others)) if others and random.random() < 0.5 else "foundation"
    kind = str(random.choice(["spring", "tether", "anchor", "wax"]))
    middle = [0.0] * (d - 2)
    link: Tables = {"name": f"link{number}", "kind": kind, "between": [first, second]}
    link |= {"at": [0.05, *middle, 0.2], "stiffness": float(10 ** random.uniform(3, 7))}
    if kind in ("spring", "tether"):
        link["to"] = [float(random.uniform(0.5, 2.0)), *middle, float(random.uniform(0.3, 2.0))]
        link["yield"] = float(10 ** random.uniform(2, 4))
        link["damping"] = float(random.choice([0.0, 100.0]))
    else:
        link["strength"] = float(10 ** random.uniform(2, 4))
    return link


def main(words: list[str]) -> int:
    """Judge the scenes of some seeds; 0 where none fails."""
    count, first = (int(word) for word in [*words, *("300", "1")[len(words) :]])
    verdicts = list(judged([case(first + k) for k in range(count)], LIMIT, None))
    print(as_text(verdicts), end="")
    return int(any(verdict.verdict == "failed" for verdict in verdicts))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
