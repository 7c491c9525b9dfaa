"""A scene: what is to be simulated, in code and in TOML."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from solver.checking import OPEN, Checked, from_table, is_open, key_of, nearest, shown, to_table
from solver.errors import SceneError
from solver.limits import refuse_beyond
from solver.overrides import override, read_toml
from solver.specs import (
    BlockSpec,
    ColumnSpec,
    ContactSpec,
    DampingSpec,
    DeckSpec,
    Dimension,
    FoundationSpec,
    FrameCellsSpec,
    FrameSpec,
    FrictionSpec,
    HalfSineSpec,
    MotionSpec,
    NotNegative,
    OneSineSpec,
    OscillatorSpec,
    OutputSpec,
    PlateSpec,
    Platform,
    RecordSpec,
    RectangularSpec,
    RickerSpec,
    RigidSpec,
    SineSpec,
    StillSpec,
    SyntheticSpec,
    TableSpec,
    Tilt,
    TimeSpec,
    friction_law,
)

__all__ = [
    "BlockSpec",
    "ColumnSpec",
    "ContactSpec",
    "DampingSpec",
    "DeckSpec",
    "FoundationSpec",
    "FrameCellsSpec",
    "FrameSpec",
    "FrictionSpec",
    "HalfSineSpec",
    "MotionSpec",
    "OneSineSpec",
    "OscillatorSpec",
    "OutputSpec",
    "PlateSpec",
    "Platform",
    "RecordSpec",
    "RectangularSpec",
    "RickerSpec",
    "RigidSpec",
    "Scene",
    "SineSpec",
    "StillSpec",
    "SyntheticSpec",
    "TableSpec",
    "TimeSpec",
    "load_scene",
    "parse_scene",
    "read_text",
    "scene_to_toml",
    "set_values",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Checked):
    """All of a simulation's input, checked; nothing is left open in its parts."""

    title: str = ""
    dimension: Dimension = 2
    plane: Literal["strain", "stress"] = OPEN
    """2-D only: "strain" if left out; None in 3-D."""
    gravity: NotNegative = 9.81
    """g, m/s^2."""
    gravity_tilt_deg: Tilt = 0.0
    """Turns gravity towards +x, degrees: an incline."""
    blocks: tuple[BlockSpec, ...] = field(metadata={"key": "block"})
    foundation: FoundationSpec = field(default_factory=RigidSpec)
    contact: ContactSpec = field(default_factory=ContactSpec)
    damping: DampingSpec | None = None
    motion: MotionSpec | None = None
    time: TimeSpec
    output: OutputSpec = field(default_factory=OutputSpec)

    def __post_init__(self) -> None:
        """Check the values, and fill in what depends on the dimension."""
        Checked.__post_init__(self)
        if not self.blocks:
            raise SceneError("block", "0 blocks", "one block or more, [[block]]")
        self._check_names()
        order = self.order  # refuses circles
        if self.dimension == 2 and is_open(self.plane):
            object.__setattr__(self, "plane", "strain")
        if self.dimension == 3 and not is_open(self.plane):
            raise SceneError("plane", shown(self.plane), "nothing where dimension = 3")
        object.__setattr__(self, "blocks", tuple(self._filled(block) for block in self.blocks))
        self._check_thickness(order[0])
        try:
            foundation = self.foundation.in_dimension(self.dimension, self.blocks[0].thickness)
        except SceneError as error:
            raise error.under("foundation") from None
        object.__setattr__(self, "foundation", foundation)
        if self.dimension == 2 and self.motion is not None and self.motion.second is not None:
            raise SceneError("motion.second", "a table", "nothing where dimension = 2")
        refuse_beyond(self)
        if self.time.adaptive and self.is_rigid:
            # Their steps are cut where bodies touch and where slips end, whatever `step` is.
            allowed = "false where nothing is meshed"
            raise SceneError("time.adaptive", "true", allowed)

    def _check_names(self) -> None:
        """Every block has a name of its own and stands on something that is there."""
        names = [block.name for block in self.blocks]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise SceneError(f"{twice}.name", "one name twice", "a name of its own for each block")
        for block in self.blocks:
            carriers = ["foundation", *(name for name in names if name != block.name)]
            if block.on not in carriers:
                allowed = " or ".join(map(shown, carriers))
                meant = nearest(block.on, carriers)
                raise SceneError(f"{block.name}.on", shown(block.on), allowed, meant)

    def _filled(self, block: BlockSpec) -> BlockSpec:
        """A block with nothing left open."""
        try:
            filled = block.in_dimension(self.dimension)
            tetrahedra = filled.model == "elastic" and filled.cell == "tetrahedron"
            if tetrahedra and filled.degree == 2 and self.contact.points == "nodes":
                # Their faces have no rule with positive weights at the vertices.
                allowed = '1 for tetrahedra, or contact.points = "gauss"'
                raise SceneError("degree", "2", allowed)
        except SceneError as error:
            raise error.under(block.name) from None
        return filled

    def _check_thickness(self, first: BlockSpec) -> None:
        """In the plane all bodies are equally thick."""
        for block in self.blocks:
            if self.dimension == 2 and block.thickness != first.thickness:
                allowed = f"that of {first.name}, {first.thickness:g}, where dimension = 2"
                raise SceneError(f"{block.name}.thickness", shown(block.thickness), allowed)

    @property
    def gravity_vector(self) -> tuple[float, ...]:
        """Gravity along x and y (3-D: x, y and z), m/s^2."""
        tilt = math.radians(self.gravity_tilt_deg)
        along, down = self.gravity * math.sin(tilt), -self.gravity * math.cos(tilt)
        return (along, down) if self.dimension == 2 else (along, 0.0, down)

    @property
    def order(self) -> tuple[BlockSpec, ...]:
        """The blocks, each after what carries it, else as in the file."""
        placed: list[BlockSpec] = []
        waiting = list(self.blocks)
        while waiting:
            there = {"foundation", *(block.name for block in placed)}
            ready = [block for block in waiting if block.on in there]
            if not ready:
                circle = ", ".join(f"{block.name} on {block.on}" for block in waiting)
                raise SceneError(f"{waiting[0].name}.on", circle, "a stack that ends on foundation")
            placed += ready
            waiting = [block for block in waiting if block.on not in there]
        return tuple(placed)

    @property
    def carried_mass(self) -> float:
        """Mass of all blocks, kg."""
        return sum(block.shape.mass for block in self.blocks)

    @property
    def is_rigid(self) -> bool:
        """Whether nothing in the scene is meshed."""
        rigid = all(block.model == "rigid" for block in self.blocks)
        return rigid and isinstance(self.foundation, RigidSpec | OscillatorSpec)

    @property
    def has_platform(self) -> bool:
        """Whether the blocks stand on a spring: an oscillator, or a plate on rollers."""
        on_rollers = isinstance(self.foundation, PlateSpec) and self.foundation.support == "rollers"
        return on_rollers or isinstance(self.foundation, OscillatorSpec)

    @property
    def carrier_moves(self) -> bool:
        """Whether what carries the blocks moves as a whole: on a spring, or on columns."""
        return self.has_platform or isinstance(self.foundation, FrameSpec)

    def platform(self) -> Platform:
        """Mass, stiffness and damping of the empty platform; ValueError if there is none."""
        if self.has_platform and isinstance(self.foundation, OscillatorSpec | PlateSpec):
            return self.foundation.platform(self.carried_mass)
        raise ValueError(f"a foundation of kind {self.foundation.kind} has no spring")

    def carrier_of(self, block: BlockSpec) -> BlockSpec | None:
        """The block that carries a block; None: the foundation does."""
        return next((carrier for carrier in self.blocks if carrier.name == block.on), None)

    def friction_of(self, block: BlockSpec) -> FrictionSpec:
        """Friction between a block and what carries it."""
        return friction_law(self.contact.friction if block.friction is None else block.friction)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain tables, every default written out."""
        return to_table(self)


def load_scene(path: str | Path, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Args:
        path: The TOML file.
        overrides: Such as `"block.height=1.2"`; a block is addressed by its name.
    """
    path = Path(path)
    return parse_scene(read_text(path), folder=path.parent, overrides=overrides, source=path.name)


def read_text(path: Path) -> str:
    """The text of a scene file; the only part of reading a scene that looks at the file."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8"
        raise SceneError(str(path), f"no text ({reason.lower()})", "a scene in TOML") from None


def parse_scene(
    content: str | Mapping[str, Any],
    *,
    folder: str | Path = ".",
    overrides: Sequence[str] = (),
    source: str = "scene",
) -> Scene:
    """A scene from the text of a TOML file, or from its tables.

    Args:
        content: Text, or plain tables as `tomllib` makes them.
        folder: Where relative names of files start from.
        overrides: As for `load_scene`.
        source: What errors call the text as a whole.
    """
    tables = read_toml(content, source) if isinstance(content, str) else deepcopy(dict(content))
    if not tables:
        raise SceneError(source, "an empty scene", "at least [[block]] and [time]")
    set_values(tables, overrides)
    _find_files(tables.get("motion"), "motion", folder)
    scene: Scene = from_table(Scene, tables)
    return scene


def set_values(tables: dict[str, Any], overrides: Sequence[str]) -> None:
    """Set values in the tables of a scene, which are changed in place.

    Args:
        tables: Plain tables as `tomllib` makes them.
        overrides: As for `load_scene`.
    """
    known = [key_of(item) for item in fields(Scene)]
    for text in overrides:
        override(tables, text, known=known)


def _find_files(motion: Any, where: str, folder: str | Path) -> None:
    """Make the names of the files of a motion absolute, and refuse those that are not there."""
    if not isinstance(motion, dict):
        return
    if motion.get("kind") in ("record", "table") and isinstance(motion.get("file"), str):
        motion["file"] = os.path.abspath(os.path.join(folder, motion["file"]))
        # os.path, unlike pathlib, says False to names that no file can have.
        if not os.path.isfile(motion["file"]):
            got = motion["file"] + " (a folder)" * os.path.isdir(motion["file"])
            raise SceneError(f"{where}.file", got, "a file that exists")
    for direction in ("vertical", "second"):
        _find_files(motion.get(direction), f"{where}.{direction}", folder)


def scene_to_toml(scene: Scene) -> str:
    """The scene as text that `parse_scene` reads back to an equal scene."""
    import tomli_w

    text: str = tomli_w.dumps(scene.to_dict())
    return text
