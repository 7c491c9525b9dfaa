"""One run of the study: a scene, and what its impacts keep."""

from __future__ import annotations

import hashlib
import json
import math
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solver.errors import SceneError, Statement
from solver.scene import BlockSpec, Scene, parse_scene
from solver.scene.checking import nearest, shown
from solver.study.damping.axes import Axis, Tables
from solver.types import Array

SPACING = 1e-3
"""Least time between two rows of the angle that is kept, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingCase:
    """Case of the study, as one process is given it.

    Attributes:
        key: Made from the scene: equal scenes have one key, and are run once.
        name: What is set in it, for the display.
        scene: What is run.
        block: Name of the block whose impacts count.
    """

    key: str
    name: str
    scene: Scene
    block: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseScene:
    """Base scene of a study: what is varied.

    Attributes:
        tables: As plain tables, with what the command line sets.
        scene: The same, checked.
        block: The block whose impacts count.
        end: Time at which its runs end, s.
    """

    tables: Tables
    scene: Scene
    block: BlockSpec
    end: float

    def with_values(self, *changes: tuple[Axis, float]) -> Tables:
        """Its tables with values set."""
        tables = deepcopy(self.tables)
        for axis, value in changes:
            # Later axes start from what earlier ones made, such as cells of a floor put in.
            axis.put(tables, parse_scene(tables), self.block, value)
        return tables

    def case(self, *changes: tuple[Axis, float]) -> DampingCase:
        """The case in which values are set; SceneError where a scene does not take them."""
        tables = self.with_values(*changes)
        tables["time"]["end"] = self.end
        scene = parse_scene(tables)
        words = ", ".join(f"{axis.name} {value:g}" for axis, value in changes)
        return DampingCase(
            key=digest(scene), name=words or "the scene", scene=scene, block=self.block.name
        )


def digest(scene: Scene) -> str:
    """A key made from all that a scene says but its title."""
    said = json.dumps(replace(scene, title="").to_dict(), sort_keys=True)
    return hashlib.sha256(said.encode()).hexdigest()[:12]


def watched(scene: Scene, name: str | None) -> BlockSpec:
    """The block whose impacts count.

    Args:
        scene: Where it stands.
        name: Its name; None: the first one with a mesh.
    """
    meshed = [block for block in scene.blocks if block.model == "elastic"]
    if not meshed:
        what = 'has no meshed block; what impacts keep is "restitution" of a rigid one'
        raise Statement("scene", what)
    if name is None:
        return meshed[0]
    names = [block.name for block in meshed]
    if name not in names:
        raise SceneError("--block", shown(name), " or ".join(names), nearest(name, names))
    return meshed[names.index(name)]


def time_for(scene: Scene, block: BlockSpec, impacts: int) -> float:
    """Time in which a block released from a tilt has so many impacts and the peak after them, s.

    That of a rigid block that loses nothing, which takes longest, to two digits; the end of the
    scene if that is sooner, and for all other scenes.
    """
    from solver.reference.housner import housner

    still = (
        scene.motion is None and not scene.foundation.is_meshed and not scene.foundation.on_spring
    )
    free = scene.dimension == 2 and len(scene.blocks) == 1 and block.tilt and scene.gravity
    upright = not scene.gravity_tilt_deg and not block.angular_velocity and not any(block.velocity)
    if not (still and free and upright) or abs(block.tilt) >= block.shape.slenderness:
        return scene.time.end
    longest = housner(
        block.shape,
        gravity=scene.gravity,
        tilt=block.tilt,
        end=scene.time.end,
        step=scene.time.end,
        restitution=1.0,
    )
    if len(longest.impacts) <= impacts:
        return scene.time.end
    before, after = longest.impacts[impacts - 1 : impacts + 1]
    time = float(before + 0.6 * (after - before))
    power = 10.0 ** (math.floor(math.log10(time)) - 1)
    return min(scene.time.end, float(f"{math.ceil(time / power) * power:.2g}"))


def run_case(case: DampingCase) -> dict[str, Any]:
    """Run a case on one process; its row, with the angle against time under `angle`."""
    from mpi4py import MPI

    from solver.results.endings import cut_short
    from solver.results.motion import block_motion
    from solver.run.simulate import simulate

    result = simulate(case.scene, comm=MPI.COMM_SELF)
    summary = result.summary
    block, energy, cost = summary["blocks"][case.block], summary["energy"], summary["cost"]
    spec = next(spec for spec in case.scene.blocks if spec.name == case.block)
    motion = block_motion(case.scene, result.history, spec)
    return {
        "status": result.status,
        "reason": summary["reason"],
        "end_s": summary["end_s"],
        "cut_short": cut_short(summary),
        "mode": block["mode"],
        "impacts": block["impacts"],
        "peaks": block["peaks"],
        "loss_share": energy["loss_share"],
        "largest_gain_fraction": energy["largest_gain_fraction"],
        "ledger_error_fraction": energy["ledger_error_fraction"],
        "steps": cost["steps"],
        "rejected_steps": cost["rejected_steps"],
        "wall_s": cost["wall_s"],
        "angle": spaced(motion.time, motion.angle),
    }


def spaced(time: Array, angle: Array) -> list[tuple[float, float]]:
    """Rows of time and angle, no two of them nearer than `SPACING`."""
    number = np.floor(time / SPACING)
    kept = np.concatenate([[True], np.diff(number) > 0])
    return list(zip(time[kept].tolist(), angle[kept].tolist(), strict=True))
