"""The parameters that restitution is measured against: how each is set, and the runs they make."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from mpi4py import MPI

import numpy as np

from solver.errors import SceneError, Statement, not_applicable
from solver.reference.housner import housner
from solver.results.endings import cut_short
from solver.results.motion import BlockMotion
from solver.run.simulate import simulate
from solver.scene import BlockSpec, Scene, parse_scene
from solver.scene.checking import nearest, shown, to_table
from solver.scene.damping import DEFAULT_RATIO, stiffness_damping
from solver.study.scenes import Changes, Tables, changed
from solver.study.study import Row, digest, numbers_by_name
from solver.types import Array

Chosen = Callable[[Scene, BlockSpec], tuple[float, ...]]
"""Values that suit a scene and a block."""

STEPS_OF_CROSSINGS = (4.0, 2.0, 1.0, 0.5, 0.2)
"""Fixed steps, over the time in which sound crosses the height of the block."""

BETAS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""beta_R over the power of ten below that of 2 % of critical damping."""

BETA_BOUNDS = (0.25, 5.0)
"""Bounds of beta_R for calibration, over that of 2 % of critical damping. Below them vibration
lasts from impact to impact; above them more damping takes less, not more, from an impact."""

SPACING = 1e-3
"""Least time between two rows of the angle that is kept, s."""

ALLOWED = "NAME or NAME=V1,V2,..., such as beta=0,1e-5,1e-4"


@dataclass(frozen=True, slots=True)
class Axis:
    """A parameter that is swept.

    Attributes:
        name: On the command line.
        key: What is set, for headings: the key of the scene, or words.
        unit: Of its values; "" without one.
        meaning: "physical": a property of the blocks; "numerical": of the method.
        values: Values that suit a scene.
        limit: Where its limit is: at zero, at infinity, or nowhere.
        changes: What a value sets in a scene, for a block; None: the key itself.
        bounds: Least and largest value of a calibration; None: it is not one to calibrate.
    """

    name: str
    key: str
    unit: str
    meaning: Literal["physical", "numerical"]
    values: Chosen
    limit: Literal["zero", "infinity", ""] = ""
    changes: Callable[[Scene, BlockSpec, float], Changes] | None = None
    bounds: Chosen | None = None

    def __reduce__(self) -> tuple[Callable[[str], Axis], tuple[str]]:
        """By its name when it is sent to another process, which has the same axes."""
        return axis_called, (self.name,)

    @property
    def label(self) -> str:
        """Name and unit, for the axis of a picture."""
        return f"{self.key} ({self.unit})" if self.unit else self.key

    def distance(self, value: float) -> float:
        """Distance of a value from the limit, in any unit; meaningless without a limit."""
        return 1 / value if self.limit == "infinity" else value


def _fixed(*values: float) -> Chosen:
    """Values that do not depend on the scene."""
    return lambda scene, block: values


def _times(*ratios: float, of: Callable[[Scene, BlockSpec], float], digits: int = 3) -> Chosen:
    """Multiples of a value of the scene."""
    return lambda scene, block: tuple(float(f"{r * of(scene, block):.{digits}g}") for r in ratios)


def _step(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """Fixed steps of a size, s."""
    gone = ("adaptive", "tolerance", "largest", "smallest")
    return {"time.step": value, **{f"time.{key}": None for key in gone}}


def _steps(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """Fixed steps around the time in which sound crosses the block, s."""
    crossing = block.height * math.sqrt(block.shape.density / _young(scene, block))
    steps = dict.fromkeys(_round(ratio * crossing) for ratio in STEPS_OF_CROSSINGS)
    return tuple(step for step in steps if step <= scene.time.end / 10)


def _round(value: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    digit = min((1, 2, 5, 10), key=lambda digit: abs(math.log(digit * power / value)))
    return float(f"{digit * power:.0e}")


def _tolerance(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """Adaptive steps of a tolerance."""
    gone = () if scene.time.adaptive else ("step", "smallest", "damped_steps")
    return {"time.tolerance": value, **{f"time.{key}": None for key in gone}}


def _damped_steps(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """Damped steps after a change of contact: a whole number."""
    return {"time.damped_steps": int(value) if value.is_integer() else value}


def _mesh(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """The numbers of cells of all meshed bodies, times a factor."""
    if not value > 0:
        raise SceneError("--of mesh", shown(value), "factors > 0")

    def finer(count: int) -> int:
        return max(1, round(value * count))

    made: dict[str, Any] = {}
    for spec in scene.blocks:
        if spec.takes_mesh:
            what = f"blocks that are meshed: {spec.name} has the mesh of its file"
            raise not_applicable("--of mesh", what)
        if spec.model == "elastic" and not spec.is_box:
            made[f"{spec.name}.cell_size"] = spec.cell_size / value
        elif spec.model == "elastic":
            made[f"{spec.name}.cells"] = list(map(finer, spec.cells))
    if scene.foundation.is_meshed:
        made["foundation.cells"] = to_table(scene.foundation.refined(finer))["cells"]
    return made


def _young(scene: Scene, block: BlockSpec) -> float:
    """Young's modulus of the block, Pa."""
    assert block.young is not None  # it is meshed
    return block.young


def _other_young(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """Young's modulus of the block, Pa; its damping stays, also where that is the default."""
    kept = {f"{block.name}.damping": to_table(block.damping)} if block.damping else {}
    return {f"{block.name}.young": value, **kept}


def _beta(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """beta_R of the block where it has its own damping, or the default; else of `[damping]`, s."""
    owner = f"{block.name}." if block.damping or not scene.damping else ""
    return {f"{owner}damping.stiffness": value}


def _two_percent(scene: Scene, block: BlockSpec) -> float:
    """beta_R of 2 % of critical damping at the first bending mode, s."""
    return stiffness_damping(DEFAULT_RATIO, scene.bending_frequency(block)).stiffness


def _decade(scene: Scene, block: BlockSpec) -> float:
    """The power of ten below that, s."""
    return 10.0 ** math.floor(math.log10(_two_percent(scene, block)))


def _floor(scene: Scene, block: BlockSpec, value: float) -> Changes:
    """E of a meshed floor over that of the block."""
    if not scene.foundation.is_meshed:
        raise not_applicable("--of floor", "meshed foundations")
    return {"foundation.young": value * _young(scene, block)}


AXES = {
    axis.name: axis
    for axis in (
        Axis("step", "time.step", "s", "numerical", _steps, "zero", _step),
        Axis(
            "tolerance", "time.tolerance", "", "numerical",
            # over that of the scene, or the default
            _times(16, 4, 1, 0.25, of=lambda scene, _: scene.time.tolerance or 1e-3),
            "zero", _tolerance,
        ),
        Axis(
            "mesh", "cells of an edge over the scene's", "", "numerical",
            _fixed(0.5, 1.0, 2.0, 4.0), "infinity", _mesh,
        ),
        Axis("gamma", "contact.gamma", "", "numerical", _fixed(30.0, 100.0, 300.0, 1000.0)),
        Axis("rho_inf", "time.rho_inf", "", "numerical", _fixed(0.0, 0.5, 0.8, 1.0)),
        Axis(
            "damped_steps", "time.damped_steps", "", "numerical",
            _fixed(0.0, 2.0, 8.0, 32.0), "", _damped_steps,
        ),
        Axis(
            "beta", "beta_R", "s", "physical", _times(*BETAS, of=_decade), "", _beta,
            bounds=_times(*BETA_BOUNDS, of=_two_percent, digits=2),
        ),
        Axis(
            "contact", "contact.damping", "", "physical",
            _fixed(0.02, 0.05, 0.1, 0.2, 0.5, 1.0), bounds=_fixed(0.02, 1.0),
        ),
        Axis(
            "young", "E", "Pa", "physical",
            _times(0.1, 0.3, 1, 3, 10, of=_young), "", _other_young,
        ),
        Axis(
            "floor", "E of floor over E of block", "", "physical",
            _fixed(1.0, 3.0, 10.0, 30.0), "infinity", _floor,
        ),
    )
}  # fmt: skip
"""All of them by name, in the order in which they are listed."""


def axis_called(name: str) -> Axis:
    """The axis of that name."""
    return AXES[name]


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

    def run(self) -> Row:
        """Run the case on one process; its row, with the angle against time under `angle`."""
        result = simulate(self.scene, comm=MPI.COMM_SELF)
        summary = result.summary
        block, energy, cost = summary["blocks"][self.block], summary["energy"], summary["cost"]
        spec = next(spec for spec in self.scene.blocks if spec.name == self.block)
        motion = BlockMotion(self.scene, result.history, spec)
        return {
            "status": result.status,
            "reason": summary["reason"],
            "end_s": summary["end_s"],
            "cut_short": cut_short(summary),
            **{key: block[key] for key in ("mode", "impacts", "peaks")},
            "loss_share": energy["loss_share"],
            **{key: energy[key] for key in ("largest_gain_fraction", "ledger_error_fraction")},
            **{key: cost[key] for key in ("steps", "rejected_steps", "wall_s")},
            "angle": spaced(motion.time, motion.angle),
        }


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

    def with_value(self, axis: Axis, value: float) -> Tables:
        """Its tables with a value set."""
        changes = axis.changes or (lambda *_: {axis.key: value})
        return changed(self.tables, changes(self.scene, self.block, value))

    def case(self, axis: Axis | None = None, value: float = 0.0) -> DampingCase:
        """The case in which a value is set; SceneError where a scene does not take it."""
        tables = self.tables if axis is None else self.with_value(axis, value)
        scene = parse_scene(changed(tables, {"time.end": self.end}))
        words = "the scene" if axis is None else f"{axis.name} {value:g}"
        key = digest(replace(scene, title="").to_dict())[:12]
        return DampingCase(key=key, name=words, scene=scene, block=self.block.name)


def watched(scene: Scene, name: str | None) -> BlockSpec:
    """The block whose impacts count.

    Args:
        scene: Where it stands.
        name: Its name; None: the first one with a mesh.
    """
    meshed = {block.name: block for block in scene.blocks if block.model == "elastic"}
    if not meshed:
        what = 'has no meshed block; what impacts keep is "restitution" of a rigid one'
        raise Statement("scene", what)
    if name is None:
        return next(iter(meshed.values()))
    if name not in meshed:
        raise SceneError("--block", shown(name), " or ".join(meshed), nearest(name, list(meshed)))
    return meshed[name]


def time_for(scene: Scene, block: BlockSpec, impacts: int) -> float:
    """Time in which a block released from a tilt has so many impacts and the peak after them, s.

    That of a rigid block that loses nothing, which takes longest, to two digits; the end of the
    scene if that is sooner, and for all other scenes.
    """
    still = (
        scene.motion is None and not scene.foundation.is_meshed and not scene.foundation.on_spring
    )
    free = scene.dimension == 2 and len(scene.blocks) == 1 and block.tilt and scene.gravity
    upright = not scene.gravity_tilt_deg and not block.angular_velocity and not any(block.velocity)
    balance = block.shape.slenderness(-1 if block.tilt < 0 else 1)
    if not (still and free and upright) or abs(block.tilt) >= balance:
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


def spaced(time: Array, angle: Array) -> list[tuple[float, float]]:
    """Rows of time and angle, no two of them nearer than `SPACING`."""
    number = np.floor(time / SPACING)
    kept = np.concatenate([[True], np.diff(number) > 0])
    return list(zip(time[kept].tolist(), angle[kept].tolist(), strict=True))


class SweptValue(NamedTuple):
    """One value of an axis, and its case."""

    axis: Axis
    value: float
    case: DampingCase


def swept_values(base: BaseScene, words: Sequence[str]) -> tuple[list[SweptValue], list[str]]:
    """The values of a command line, axis by axis, and what is left out, in words.

    Args:
        base: What is varied.
        words: Axes and values; none: all axes with their default values, of which those that the
            scene does not take are left out.
    """
    axes = numbers_by_name("--of", words, tuple(AXES), ALLOWED) or dict.fromkeys(AXES, ())
    swept, left_out = list[SweptValue](), dict[str, None]()
    for axis in (axis for name, axis in AXES.items() if name in axes):
        given = axes[axis.name]
        for number, value in enumerate(sorted(given or axis.values(base.scene, base.block))):
            try:
                swept.append(SweptValue(axis, value, base.case(axis, value)))
            except SceneError as error:
                # Of an axis that is requested by name, at least the first value is possible.
                if given or (words and number == 0):
                    raise
                left_out[f"{axis.name}: {error}"] = None
    return swept, list(left_out)
