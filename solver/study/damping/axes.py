"""The parameters that restitution is measured against: how each is set, and the runs they make."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, Literal

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
from solver.study.study import Row, digest, numbers_by_name
from solver.types import Array

Tables = dict[str, Any]
"""A scene as plain tables, changed in place."""

Setter = Callable[[Tables, Scene, BlockSpec, float], None]
"""Sets a value in the tables: of which scene, for which block."""

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
        put: Sets it.
        values: Values that suit a scene.
        limit: Where its limit is: at zero, at infinity, or nowhere.
        bounds: Least and largest value of a calibration; None: it is not one to calibrate.
    """

    name: str
    key: str
    unit: str
    meaning: Literal["physical", "numerical"]
    put: Setter
    values: Chosen
    limit: Literal["zero", "infinity", ""] = ""
    bounds: Callable[[Scene, BlockSpec], tuple[float, float]] | None = None

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


def _set(*path: str) -> Setter:
    """Set the key at the end of a path."""

    def put(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
        table = tables
        for name in path[:-1]:
            table = table.setdefault(name, {})
        table[path[-1]] = value

    return put


def _fixed(*values: float) -> Chosen:
    """Values that do not depend on the scene."""
    return lambda scene, block: values


def table_of(tables: Tables, block: BlockSpec) -> Tables:
    """The table of a block."""
    entries: list[Tables] = tables["block"]
    return next(entry for entry in entries if entry.get("name", "block") == block.name)


def _put_step(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Fixed steps of a size, s."""
    for key in ("adaptive", "tolerance", "largest", "smallest"):
        tables["time"].pop(key, None)
    tables["time"]["step"] = value


def _steps(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """Fixed steps around the time in which sound crosses the block, s."""
    assert block.young is not None
    crossing = block.height * math.sqrt(block.shape.density / block.young)
    steps = dict.fromkeys(_round(ratio * crossing) for ratio in STEPS_OF_CROSSINGS)
    return tuple(step for step in steps if step <= scene.time.end / 10)


def _round(value: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    digit = min((1, 2, 5, 10), key=lambda digit: abs(math.log(digit * power / value)))
    return float(f"{digit * power:.0e}")


def _put_tolerance(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Adaptive steps of a tolerance."""
    if not scene.time.adaptive:
        for key in ("step", "smallest", "damped_steps"):
            tables["time"].pop(key, None)
    tables["time"]["tolerance"] = value


def _tolerances(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """From 16 times the tolerance of the scene, or the default, to a fourth of it."""
    own = scene.time.tolerance or 1e-3
    return tuple(float(f"{ratio * own:.3g}") for ratio in (16, 4, 1, 0.25))


def _put_damped_steps(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Damped steps after a change of contact: a whole number."""
    tables["time"]["damped_steps"] = int(value) if value.is_integer() else value


def _put_mesh(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """The numbers of cells of all meshed bodies, times a factor."""
    if not value > 0:
        raise SceneError("--of mesh", shown(value), "factors > 0")
    for spec in scene.blocks:
        if spec.takes_mesh:
            what = f"blocks that are meshed: {spec.name} has the mesh of its file"
            raise not_applicable("--of mesh", what)
        if spec.model == "elastic" and not spec.is_box:
            table_of(tables, spec)["cell_size"] = spec.cell_size / value
        elif spec.model == "elastic":
            table_of(tables, spec)["cells"] = [_times(value, count) for count in spec.cells]
    foundation = scene.foundation
    if foundation.is_meshed:
        finer = foundation.refined(lambda count: _times(value, count))
        tables["foundation"]["cells"] = to_table(finer)["cells"]


def _times(factor: float, count: int) -> int:
    """A number of cells times a factor."""
    return max(1, round(factor * count))


def _put_young(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """Young's modulus of the block, Pa; its damping stays, also where that is the default."""
    own = table_of(tables, block)
    own["young"] = value
    if block.damping is not None:
        own.setdefault("damping", to_table(block.damping))


def _put_beta(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """beta_R of `[damping]` where the block has that, else that of the block itself, s."""
    own = table_of(tables, block)
    owner = own if "damping" in own or "damping" not in tables else tables
    owner["damping"] = dict(owner.get("damping", {})) | {"stiffness": value}


def _two_percent(scene: Scene, block: BlockSpec) -> float:
    """beta_R of 2 % of critical damping at the first bending mode, s."""
    return stiffness_damping(DEFAULT_RATIO, scene.bending_frequency(block)).stiffness


def _betas(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """None, and three decades around 2 % of critical damping, s."""
    decade = 10.0 ** math.floor(math.log10(_two_percent(scene, block)))
    return tuple(float(f"{ratio * decade:.3g}") for ratio in BETAS)


def _beta_bounds(scene: Scene, block: BlockSpec) -> tuple[float, float]:
    """From 0.5 % to 10 % of critical damping, s."""
    usual = _two_percent(scene, block)
    low, high = (float(f"{ratio * usual:.1e}") for ratio in BETA_BOUNDS)
    return low, high


def _contact_bounds(scene: Scene, block: BlockSpec) -> tuple[float, float]:
    """From a fiftieth of the critical value to the critical value."""
    return 0.02, 1.0


def _put_floor(tables: Tables, scene: Scene, block: BlockSpec, value: float) -> None:
    """E of a meshed floor over that of the block; where the floor is rigid, a plate is put in."""
    assert block.young is not None
    floor = scene.foundation
    if floor.is_meshed:
        tables["foundation"]["young"] = value * block.young
        return
    standing = [spec for spec in scene.blocks if scene.carrier_of(spec) is None]
    if floor.on_spring or len(standing) > 1:
        raise not_applicable("--of floor", "meshed floors and rigid ones with one block on them")
    base = standing[0]
    if base.model == "rigid":
        raise not_applicable("--of floor", "floors under a meshed block")
    if not base.is_box:
        raise not_applicable("--of floor", "floors under a box")
    *along, _ = base.cells
    sides = [4 * base.width + 2 * abs(base.offset)]
    if scene.dimension == 3:
        sides.append(4 * base.thickness + 2 * abs(base.offset_second))
    own = [base.width, base.thickness][: len(sides)]
    cells = [round(side * n / size) for side, n, size in zip(sides, along, own, strict=True)]
    tables["foundation"] = {
        "kind": "elastic",
        "support": "bottom",
        "width": sides[0],
        "height": base.width,
        "density": base.shape.density,
        "young": value * block.young,
        "poisson": base.poisson,
        "cells": [*cells, along[0]],
        **({"thickness": sides[1]} if scene.dimension == 3 else {}),
    }
    if scene.damping is None and base.damping is not None:  # else it has that of [damping]
        tables["foundation"]["damping"] = to_table(base.damping)


def _youngs(scene: Scene, block: BlockSpec) -> tuple[float, ...]:
    """A tenth of the block's own modulus to ten times it, Pa."""
    assert block.young is not None
    return tuple(float(f"{ratio * block.young:.3g}") for ratio in (0.1, 0.3, 1, 3, 10))


AXES = {
    axis.name: axis
    for axis in (
        Axis("step", "time.step", "s", "numerical", _put_step, _steps, "zero"),
        Axis("tolerance", "time.tolerance", "", "numerical", _put_tolerance, _tolerances, "zero"),
        Axis(
            "mesh", "cells of an edge over the scene's", "", "numerical",
            _put_mesh, _fixed(0.5, 1.0, 2.0, 4.0), "infinity",
        ),
        Axis(
            "gamma", "contact.gamma", "", "numerical",
            _set("contact", "gamma"), _fixed(30.0, 100.0, 300.0, 1000.0),
        ),
        Axis(
            "rho_inf", "time.rho_inf", "", "numerical",
            _set("time", "rho_inf"), _fixed(0.0, 0.5, 0.8, 1.0),
        ),
        Axis(
            "damped_steps", "time.damped_steps", "", "numerical",
            _put_damped_steps, _fixed(0.0, 2.0, 8.0, 32.0),
        ),
        Axis("beta", "beta_R", "s", "physical", _put_beta, _betas, bounds=_beta_bounds),
        Axis(
            "contact", "contact.damping", "", "physical",
            _set("contact", "damping"), _fixed(0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
            bounds=_contact_bounds,
        ),
        Axis("young", "E", "Pa", "physical", _put_young, _youngs),
        Axis(
            "floor", "E of floor over E of block", "", "physical",
            _put_floor, _fixed(1.0, 3.0, 10.0, 30.0), "infinity",
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
            key=_key(scene), name=words or "the scene", scene=scene, block=self.block.name
        )


def _key(scene: Scene) -> str:
    """A key made from all values of a scene but its title."""
    return digest(replace(scene, title="").to_dict())[:12]


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


@dataclass(frozen=True, slots=True, kw_only=True)
class SweptValue:
    """One value of an axis, and its case.

    Attributes:
        axis: The axis.
        value: Its value.
        at: The value of the axis that the whole sweep is repeated for; None: there is none.
        case: Key of its case.
    """

    axis: Axis
    value: float
    at: float | None
    case: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A study's sweeps.

    Attributes:
        base: Key of the case of the scene as it is.
        values: All values, axis by axis.
        at: The axis that all is repeated for; None: there is none.
        cases: The cases to run, each once.
        left_out: Default values that the scene does not take, in words.
    """

    base: str
    values: tuple[SweptValue, ...]
    at: Axis | None
    cases: tuple[DampingCase, ...]
    left_out: tuple[str, ...]


def sweep(base: BaseScene, of: Sequence[str], at: Sequence[str]) -> Sweep:
    """The sweeps of a command line.

    Args:
        base: What is varied.
        of: Axes and values; none: all axes with their default values.
        at: One axis with the values for which all is repeated.
    """
    axes = numbers_by_name("--of", of, tuple(AXES), ALLOWED) or dict.fromkeys(AXES, ())
    repeated = numbers_by_name("--at", at, tuple(AXES), ALLOWED)
    if len(repeated) > 1 or repeated.keys() & axes.keys():
        raise SceneError("--at", shown(" ".join(at)), "one axis that is not swept itself")
    others: list[tuple[Axis, float] | None] = [None]
    for name, values in repeated.items():
        axis = AXES[name]
        others = [(axis, v) for v in sorted(values or axis.values(base.scene, base.block))]
    own = base.case()
    cases, swept, left_out = {own.key: own}, [], []
    for axis in (axis for name, axis in AXES.items() if name in axes):
        given = axes[axis.name]
        for other in others:
            for number, value in enumerate(sorted(given or axis.values(base.scene, base.block))):
                try:
                    case = base.case(*([other] if other else []), (axis, value))
                except SceneError as error:
                    # Of an axis that is requested by name, at least the first value is possible.
                    if given or (of and number == 0):
                        raise
                    left_out.append(f"{axis.name} {value:g}: {error}")
                    continue
                cases.setdefault(case.key, case)
                repetition = other[1] if other else None
                swept.append(SweptValue(axis=axis, value=value, at=repetition, case=case.key))
    return Sweep(
        base=own.key,
        values=tuple(swept),
        at=others[0][0] if others[0] else None,
        cases=tuple(cases.values()),
        left_out=tuple(left_out),
    )
