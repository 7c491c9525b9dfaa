"""Make the surfaces of the museum: `vase.stl`, a hollow vase with two lugs, and `statue.stl`.

Both are made up here, by formulas alone, so that everyone has the same files:

    ./in-env python3 demos/museum/make_surfaces.py

They stand beside this file, in metres; z is up.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

AROUND = 48
"""Points around each section."""

TURN: Array = 2 * np.pi * np.arange(AROUND) / AROUND

VASE = (
    *((0.0, 0.070), (0.012, 0.072), (0.03, 0.062), (0.10, 0.098), (0.17, 0.128), (0.24, 0.138)),
    *((0.30, 0.122), (0.345, 0.085), (0.38, 0.060), (0.42, 0.056), (0.445, 0.068), (0.46, 0.078)),
)
"""Height and outer radius of the vase, m."""

WALL, BOTTOM = 0.009, 0.02
"""Thickness of its wall and of its bottom, m."""

STATUE = (
    *((0.0, 0.19, 0.17), (0.05, 0.19, 0.17), (0.06, 0.155, 0.135), (0.20, 0.145, 0.125)),
    *((0.40, 0.125, 0.105), (0.55, 0.12, 0.095), (0.65, 0.15, 0.105), (0.77, 0.20, 0.115)),
    *((0.84, 0.175, 0.095), (0.88, 0.065, 0.06), (0.92, 0.055, 0.058), (0.97, 0.078, 0.088)),
    *((1.03, 0.088, 0.102), (1.08, 0.078, 0.092), (1.12, 0.045, 0.055), (1.135, 0.015, 0.02)),
)
"""Height and half axes of the statue's sections along x and along y, m."""


def smooth(levels: Array, rows: tuple[tuple[float, ...], ...]) -> Array:
    """Cubic interpolation between rows of a height and values, without overshoot."""
    from scipy.interpolate import PchipInterpolator

    table = np.array(rows)
    return np.asarray(PchipInterpolator(table[:, 0], table[:, 1:])(levels))


def ring(radius_x: Array | float, radius_y: Array | float, z: float) -> Array:
    """A closed section, (AROUND, 3)."""
    x, y = radius_x * np.cos(TURN), radius_y * np.sin(TURN)
    return np.stack([x, y, np.full(AROUND, z)], axis=1)


def vase() -> list[Array]:
    """Sections from the middle of its bottom over its outside and its rim into it."""
    top = VASE[-1][0]
    levels = np.unique(np.concatenate([np.linspace(0, top, 26), [h for h, _ in VASE]]))
    rings = []
    for z, (radius,) in zip(levels, smooth(levels, VASE), strict=True):
        lugs = 0.035 * np.exp(-(((z - 0.30) / 0.022) ** 2)) * np.exp(-((np.sin(TURN) / 0.22) ** 2))
        rings.append(ring(radius + lugs, radius + lugs, float(z)))
    inner = np.linspace(top, BOTTOM, 16)
    for z, (radius,) in zip(inner, smooth(inner, VASE), strict=True):
        rings.append(ring(radius - WALL, radius - WALL, float(z)))
    return rings


def statue() -> list[Array]:
    """Sections from its bottom to the top of its head."""
    levels = np.unique(np.concatenate([np.linspace(0, STATUE[-1][0], 36), [0.05, 0.06]]))
    rings = []
    for z, (wide, deep) in zip(levels, smooth(levels, STATUE), strict=True):
        robe = float(np.clip((z - 0.06) / 0.05, 0, 1) * np.clip((0.6 - z) / 0.3, 0, 1))
        folds = 1 + 0.045 * robe * np.cos(12 * TURN + 2.0 * z)
        face = np.exp(-(((TURN - 1.5 * np.pi) / 0.16) ** 2)) * np.exp(-(((z - 1.01) / 0.022) ** 2))
        section = ring(wide * folds, deep * folds + 0.024 * face, float(z))
        section[:, 0] += 0.012 * np.sin(5.0 * z) * np.clip((z - 0.06) / 0.3, 0, 1)
        rings.append(section)
    return rings


def triangles(rings: list[Array]) -> Array:
    """Triangles between sections, and to the middles of the first and of the last one."""
    found = []
    for lower, upper in pairwise(rings):
        for k in range(AROUND):
            n = (k + 1) % AROUND
            found += [(lower[k], lower[n], upper[n]), (lower[k], upper[n], upper[k])]
    for section, turns in ((rings[0], (1, 0)), (rings[-1], (0, 1))):
        middle = section.mean(axis=0)
        for k in range(AROUND):
            pair = [section[k], section[(k + 1) % AROUND]]
            found.append((middle, pair[turns[0]], pair[turns[1]]))
    return np.array(found)


def write(file: Path, rings: list[Array]) -> None:
    """A binary STL file."""
    corners = triangles(rings).astype("<f4")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    facets = np.zeros(len(corners), dtype=kind)
    facets["normal"], facets["corners"] = normals, corners
    head = b"made up by demos/museum/make_surfaces.py of rockslip".ljust(80)
    file.write_bytes(head + np.uint32(len(facets)).tobytes() + facets.tobytes())


def main() -> None:
    """Write both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    here = Path(__file__).resolve().parent
    parser.add_argument("-o", "--output", type=Path, default=here, help="folder of both files")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for name, rings in (("vase", vase()), ("statue", statue())):
        write(folder / f"{name}.stl", rings)


if __name__ == "__main__":
    main()
