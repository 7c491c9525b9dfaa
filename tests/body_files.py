"""Files of bodies that tests write: surfaces of STL, meshes of Gmsh, solids of STEP."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from solver.types import Array, Indices


def vase(around: int, levels: int) -> tuple[Array, Indices]:
    """Points, m, and triangles of a vase 0.5 m high, about the vertical axis, on its flat foot."""
    angles = 2 * math.pi * np.arange(around) / around
    heights = np.linspace(0.0, 0.5, levels)
    radii = 0.12 + 0.05 * np.sin(3.6 * math.pi * heights + 0.3)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [
        np.column_stack([r * circle, np.full(around, z)])
        for r, z in zip(radii, heights, strict=True)
    ]
    points = np.concatenate([[[0.0, 0.0, 0.0]], *rings, [[0.0, 0.0, 0.5]]])
    here = np.arange(around)
    after = (here + 1) % around
    triangles = [np.column_stack([0 * here, 1 + after, 1 + here])]
    for level in range(levels - 1):
        low, high = 1 + level * around, 1 + (level + 1) * around
        triangles.append(np.column_stack([low + here, low + after, high + after]))
        triangles.append(np.column_stack([low + here, high + after, high + here]))
    last = 1 + (levels - 1) * around
    triangles.append(np.column_stack([0 * here + len(points) - 1, last + here, last + after]))
    return points, np.concatenate(triangles)


def write_stl(file: Path, points: Array, triangles: Indices) -> Path:
    """Write a binary STL file; returns it."""
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
    facets = np.zeros(len(triangles), dtype=facet)
    facets["corners"] = points[triangles]
    head = b" " * 80 + len(triangles).to_bytes(4, "little")
    file.write_bytes(head + facets.tobytes())
    return file


def write_by_gmsh(file: Path, build: Callable[[], None], version: float = 4.1) -> Path:
    """Write what `build` makes in a Gmsh model, as its name's end says; returns the file."""
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.model.add("file")
        build()
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    return file


def boxes(*given: tuple[float, ...], size: float | None = None, dimension: int = 3) -> None:
    """Boxes by OpenCASCADE, (x, y, z, width, thickness, height) each, meshed where `size` is given.

    Up to cells or facets of a dimension.
    """
    import gmsh

    for box in given:
        gmsh.model.occ.addBox(*box)
    gmsh.model.occ.synchronize()
    if size is not None:
        gmsh.model.mesh.setSize(gmsh.model.getEntities(0), size)
        gmsh.model.mesh.generate(dimension)
