"""The rigid-body answer to a scene, in the columns of its history; what it does not know is nan."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solver.errors import SceneError, Statement
from solver.excitation.motion import GroundMotion, read_ground
from solver.history.history import History, scene_columns
from solver.reference.expected import expected_mode
from solver.reference.rows import ONLY, rock, slide, slide_on_platform
from solver.scene import Scene
from solver.scene.checking import shown

#: Names of the answers.
ROCKING, SLIDING = "rigid block, Housner 1963", "rigid block, sliding"
ON_PLATFORM = "rigid block on a platform, sliding"


def reference_name(scene: Scene, ground: GroundMotion | None = None) -> str:
    """Which answer a scene has.

    On a platform the block slides; on firm ground it rocks, unless it slides from rest and stays
    flat, or the ground also moves vertically.

    Args:
        scene: What is asked.
        ground: Its motion of the ground, as it was read; None: it is read here.

    Raises:
        SceneError: There is none.
    """
    ground = ground or read_ground(scene)
    _refuse(scene, ground)
    if scene.has_platform:
        return ON_PLATFORM
    mode, block = expected_mode(scene, ground), scene.blocks[0]
    if block.velocity[0] and mode != "slide":
        got = f"{shown(block.velocity)} of a block that may {mode}"
        raise SceneError(f"{block.name}.velocity", got, f"[0, 0] {ONLY}")
    if ground.up is not None:
        if mode not in ("rest", "slide"):
            raise Statement("motion.vertical", f"has no rigid-body reference if blocks may {mode}")
        return SLIDING
    return SLIDING if mode == "slide" else ROCKING


def reference_history(
    scene: Scene, file: Path | None = None, ground: GroundMotion | None = None
) -> History:
    """The rigid-body answer: Housner's rocking without sliding, or sliding without rocking.

    Args:
        scene: What is asked; SceneError where there is no answer.
        file: CSV file to write, too.
        ground: Motion of the ground, as it was read; None: it is read here.
    """
    ground = ground or read_ground(scene)
    name = reference_name(scene, ground)
    answers = {ROCKING: rock, SLIDING: slide, ON_PLATFORM: slide_on_platform}
    known = answers[name](scene, ground)
    history = History(scene_columns(scene), file)
    unknown = np.full_like(known["time_s"], np.nan)
    table = np.stack([known.get(name, unknown) for name in history.columns], axis=1)
    for row in table[:: scene.output.history_every]:
        history.append(row)
    history.flush()
    return history


def _refuse(scene: Scene, ground: GroundMotion) -> None:
    """Refuse a scene that no reference answers, in one line."""
    block = scene.blocks[0]
    if scene.dimension != 2:
        raise SceneError("dimension", "3", f"2 {ONLY}")
    if len(scene.blocks) != 1:
        raise SceneError("block", f"{len(scene.blocks)} blocks", f"one block {ONLY}")
    if not scene.friction_of(block).has_reference:
        got = scene.friction_of(block).words()
        raise SceneError("contact.friction", got, f"static, dynamic, decay, cohesion {ONLY}")
    if scene.gravity == 0:
        raise SceneError("gravity", "0", f"gravity > 0 {ONLY}")
    if scene.carrier_moves and not scene.has_platform:
        raise SceneError("foundation.kind", shown(scene.foundation.kind), f"any other kind {ONLY}")
    if block.angular_velocity:
        raise SceneError(
            f"{block.name}.angular_velocity", shown(block.angular_velocity), f"0 {ONLY}"
        )
    if block.velocity[1] or (block.velocity[0] and block.tilt):
        allowed = f"[0, 0], or [v, 0] without a tilt, {ONLY}"
        raise SceneError(f"{block.name}.velocity", shown(block.velocity), allowed)
    if scene.has_platform and block.tilt:
        raise SceneError(f"{block.name}.tilt_deg", shown(block.tilt_deg), f"0 on a platform {ONLY}")
    vertical = ground.up
    if vertical is not None and vertical.peak >= -scene.gravity_vector[1]:
        raise SceneError("motion.vertical", f"{vertical.peak:g} m/s2", f"less than gravity {ONLY}")
