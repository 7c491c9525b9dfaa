"""The rigid-body answer to a scene, in the columns of its history; what it does not know is nan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from solver.errors import SceneError
from solver.excitation.motion import GroundMotion, read_ground
from solver.history.events import NAME as EVENTS
from solver.history.events import events_text
from solver.history.history import History, scene_columns
from solver.reference.expected import expected_mode, resistance
from solver.reference.rocking_rows import rock, rock_on_platform
from solver.reference.rows import ONLY, slide, slide_on_platform
from solver.results.endings import Watch
from solver.results.events import Recorder
from solver.scene import Scene
from solver.scene.checking import shown
from solver.types import Array

#: Names of the answers.
ROCKING, SLIDING = "rigid block, Housner 1963", "rigid block, sliding"
ON_PLATFORM = "rigid block on a platform, sliding"
ROCKING_ON_PLATFORM = "rigid block on a platform, rocking"

ANSWERS: dict[str, Callable[[Scene, GroundMotion], dict[str, Array]]] = {
    ROCKING: rock,
    SLIDING: slide,
    ON_PLATFORM: slide_on_platform,
    ROCKING_ON_PLATFORM: rock_on_platform,
}
"""What computes each of them: columns of a history by their names."""


def reference_name(scene: Scene, ground: GroundMotion | None = None) -> str:
    """Which answer a scene has.

    On a platform a block rocks that is tilted, or that friction holds at rest until it uplifts;
    others slide. On firm ground it rocks, unless it slides from rest and stays flat.

    Args:
        scene: What is asked.
        ground: Its motion of the ground, as it was read; None: it is read here.

    Raises:
        SceneError: There is none.
    """
    ground = ground or read_ground(scene)
    _refuse(scene, ground)
    if scene.has_platform:
        return ROCKING_ON_PLATFORM if _pivots_on_platform(scene) else ON_PLATFORM
    mode, block = expected_mode(scene, ground), scene.blocks[0]
    if block.velocity[0] and mode != "slide":
        got = f"{shown(block.velocity)} of a block that may {mode}"
        raise SceneError(f"{block.name}.velocity", got, f"[0, 0] {ONLY}")
    slides = mode == "slide" or (mode == "rest" and ground.up is not None)
    return SLIDING if slides else ROCKING


def reference_history(
    scene: Scene, file: Path | None = None, ground: GroundMotion | None = None
) -> History:
    """The history of the rigid-body answer; arguments as those of `reference_run`."""
    return reference_run(scene, file, ground)[0]


def reference_run(
    scene: Scene, file: Path | None = None, ground: GroundMotion | None = None
) -> tuple[History, str]:
    """The rigid-body answer: rocking without sliding, or sliding without rocking.

    Args:
        scene: What is asked; SceneError where there is no answer.
        file: CSV file to write, too.
        ground: Motion of the ground, as it was read; None: it is read here.

    Returns:
        The history, and why it ends before `time.end`, in words: empty where it does not.
    """
    ground = ground or read_ground(scene)
    known = ANSWERS[reference_name(scene, ground)](scene, ground)
    history = History(scene_columns(scene), file)
    unknown = np.full_like(known["time_s"], np.nan)
    table = np.stack([known.get(name, unknown) for name in history.columns], axis=1)
    ending = Watch(scene).look(table)
    every, last = scene.output.history_every, ending.row if ending else len(table) - 1
    for number in range(0, last + 1, every):
        history.append(table[number])
    if last % every:
        history.append(table[last])
    history.flush()
    recorder = Recorder(scene, history.columns, rigid=True)
    recorder.add(table[: last + 1])
    # Its forces have no impulses.
    history.events = tuple(replace(event, impulse_Ns=np.nan) for event in recorder.finish())
    if file is not None:
        file.with_name(EVENTS).write_text(events_text(history.events), encoding="utf-8")
    return history, ending.reason if ending else ""


def _pivots_on_platform(scene: Scene) -> bool:
    """Whether the block is tilted, or at rest and held by friction until it uplifts: mu > B/H."""
    block, down = scene.blocks[0], -scene.gravity_vector[1]
    if block.tilt or block.velocity[0]:
        return bool(block.tilt)
    return resistance(scene).holds(down, slipped=False) * block.height > down * block.width


def _refuse(scene: Scene, ground: GroundMotion) -> None:
    """Refuse a scene that no reference answers, in one line."""
    block = scene.blocks[0]
    if scene.dimension != 2:
        raise SceneError("dimension", "3", f"2 {ONLY}")
    if len(scene.blocks) != 1:
        raise SceneError("block", f"{len(scene.blocks)} blocks", f"one block {ONLY}")
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
    vertical = ground.up
    if vertical is not None and vertical.peak >= -scene.gravity_vector[1]:
        raise SceneError("motion.vertical", f"{vertical.peak:g} m/s2", f"less than gravity {ONLY}")
