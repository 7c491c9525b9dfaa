"""What a scene means, without solving it: derived numbers, expected mode, size."""

from __future__ import annotations

import math

from solver.excitation.motion import base_motion
from solver.reference.answer import expected_mode
from solver.reference.housner import housner_restitution
from solver.scene import Scene
from solver.specs import BlockSpec


def describe(scene: Scene) -> str:
    """What a scene means: derived numbers, expected mode, size of the mesh, steps."""
    motion = base_motion(scene.motion, scene.time.end)
    lines = [("scene", scene.title or "without a title")]
    for block in scene.blocks:
        lines += _block_numbers(block, scene)
    peak = (
        f"peak {motion.peak / scene.gravity:.4g} g = {motion.peak:.4g} m/s2" if motion else "none"
    )
    steps = math.ceil(scene.time.end / scene.time.step * (1 - 1e-12))
    lines += [
        ("friction", f"{scene.contact.friction:g}"),
        ("base motion", peak),
        ("expected mode", f"{expected_mode(scene)} (rigid block; Shenton 1996)"),
        *(("mesh", _mesh(block)) for block in scene.blocks),
        ("time", f"{steps} steps of {scene.time.step:g} s to {scene.time.end:g} s"),
    ]
    return table(lines)


def _block_numbers(block: BlockSpec, scene: Scene) -> list[tuple[str, str]]:
    """Numbers of rigid-body rocking."""
    shape = block.shape
    tilt = f", released from {block.tilt_deg:g} degrees" if block.tilt_deg else ""
    alpha = shape.slenderness
    return [
        (block.name, f"{block.width:g} x {block.height:g} x {block.thickness:g} m{tilt}"),
        ("  mass", f"{shape.mass:.6g} kg ({shape.density:.6g} kg/m3)"),
        ("  half diagonal R", f"{shape.half_diagonal:.4f} m"),
        ("  slenderness alpha", f"{alpha:.5f} rad = {math.degrees(alpha):.3f} degrees"),
        ("  frequency p", f"{shape.frequency(-scene.gravity_vector[1]):.4f} 1/s"),
        ("  uplift at", f"{_uplift(block, scene):.4f} g"),
        ("  restitution", f"{housner_restitution(shape):.4f} (Housner 1963)"),
    ]


def _uplift(block: BlockSpec, scene: Scene) -> float:
    """Horizontal acceleration of the base over gravity at which the block uplifts."""
    along, down = scene.gravity_vector
    return max(0.0, -down * block.width / block.height - abs(along)) / scene.gravity


def _mesh(block: BlockSpec) -> str:
    """Size of the mesh of a block; Gmsh makes two triangles of each cell."""
    across, up = block.cells
    nodes = (block.degree * across + 1) * (block.degree * up + 1)
    cells = across * up * (2 if block.cell == "triangle" else 1)
    return f"{cells} {block.cell}s of degree {block.degree}, {nodes} nodes, {2 * nodes} unknowns"


def table(lines: list[tuple[str, str]]) -> str:
    """Names and values in two columns."""
    width = max(len(name) for name, _ in lines) + 2
    return "".join(f"{name:{width}}{value}\n" for name, value in lines)
