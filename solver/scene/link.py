"""Links between two bodies, or a block and the ground."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from solver.errors import SceneError, Statement, missing_key, not_applicable
from solver.scene.checking import OPEN, Checked, is_open, key_of, shown
from solver.scene.names import refuse_name
from solver.scene.quantities import (
    Dashpot,
    Gap,
    Length,
    Position,
    Preload,
    Spring,
    Strength,
)


class Kind(NamedTuple):
    """What a kind of link is, and the keys that it has beyond those of all."""

    axial: bool
    """True if it acts along the line between its ends; else along axes."""
    pulls: bool
    """True if it acts in tension only; along axes: upwards."""
    takes: tuple[str, ...]
    needs: tuple[str, ...] = ()
    """Keys that it cannot do without."""


KINDS = {
    "spring": Kind(True, False, ("length", "gap", "preload", "strength", "yield"), ("to",)),
    "tether": Kind(True, True, ("length", "gap", "strength", "yield"), ("to",)),
    "lashing": Kind(True, True, ("length", "gap", "preload", "strength", "yield"), ("to",)),
    "post-tension": Kind(True, True, ("preload", "strength", "yield"), ("to", "preload")),
    "anchor": Kind(False, False, ("shear_stiffness", "strength", "yield")),
    "wax": Kind(False, False, ("shear_stiffness", "strength"), ("strength",)),
    "twist-lock": Kind(False, True, ("shear_stiffness", "gap", "shear_gap", "strength")),
}
"""The kinds: a new one is an entry here, a name in the type of `LinkSpec.kind`, and a row in
docs/scene.md."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkSpec(Checked):
    """A link: `[[link]]`."""

    name: str = "link"
    """Its name, as that of a block, and different from those of all blocks, links and forces."""
    kind: Literal["spring", "tether", "lashing", "post-tension", "anchor", "wax", "twist-lock"] = (
        "spring"
    )
    """What it is; see the [kinds](#kinds-of-links)."""
    between: tuple[str, str]
    """Names of two blocks, or of one and `"foundation"`; along axes those of the first one."""
    at: Position
    """Place of its end on the first body, m: from the middle of the bottom of the block as it
    stands upright, or from the middle of the foundation's top, with which it moves."""
    to: Position | None = None
    """Place of its end on the second body, m, likewise. Default: along axes where `at` is at the
    start; else required."""
    stiffness: Spring
    """k, N/m."""
    shear_stiffness: Spring = OPEN
    """k along the horizontal axes, N/m; along axes only. Default: `stiffness`."""
    damping: Dashpot = 0.0
    """Coefficient of a dashpot, which acts where the spring does, N s/m."""
    length: Length | None = None
    """Length at which it is not stretched, m; axial only, without `preload`. Default: the distance
    of its ends at the start."""
    gap: Gap = OPEN
    """Extension before it resists, m; of a twist-lock upwards. Default: 0."""
    shear_gap: Gap = OPEN
    """Play along the horizontal axes, to each side, m; twist-lock only. Default: 0."""
    preload: Preload | None = None
    """Tension at the start, N; without `gap`. Default: post-tension: required; else 0."""
    strength: Strength | None = None
    """Force at which it breaks for good, N; along axes that of all together. Default: wax:
    required; else it does not break."""
    yields: Strength | None = field(default=None, metadata={"key": "yield"})
    """Force at which it flows, N; along each axis by itself. Not with `strength`. Default: it stays
    elastic."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """The stiffness along the horizontal axes, where it is that along the vertical."""
        if is_open(self.shear_stiffness) and not self.is_axial:
            yield "shear_stiffness", self.stiffness

    def check(self) -> None:
        """Refuse keys that a kind does not have, and values that do not go together."""
        refuse_name(self.name)
        kind = KINDS[self.kind]
        given = {key: value for key, value in self._particular() if value is not None}
        for key in given.keys() - kind.takes:
            of = [name for name, each in KINDS.items() if key in each.takes]
            raise not_applicable(key, f"{', '.join(of)}, not to kind = {shown(self.kind)}")
        for key in kind.needs:
            if getattr(self, key) is None:
                raise missing_key(key, f"where kind = {shown(self.kind)}")
        if self.between[0] == self.between[1]:
            raise SceneError("between", shown(self.between), "two different names")
        if self.preload:
            for key in ("gap", "length"):
                if given.get(key):
                    raise not_applicable(key, "links without preload, which sets what it pulls")
        if self.strength is not None and self.yields is not None:
            raise Statement("strength", "and yield exclude each other: it breaks, or it flows")
        bound = self.strength or self.yields
        if self.preload is not None and bound is not None and self.preload >= bound:
            key = "yield" if self.strength is None else "strength"
            raise SceneError("preload", shown(self.preload), f"preload < {key} = {bound:g}")

    def _particular(self) -> Iterator[tuple[str, Any]]:
        """The keys that not all kinds have, with their values."""
        every = {key for kind in KINDS.values() for key in kind.takes}
        for own in self.__dataclass_fields__.values():
            if key_of(own) in every:
                yield key_of(own), getattr(self, own.name)

    @property
    def is_axial(self) -> bool:
        """True if it acts along the line between its ends; else along axes."""
        return KINDS[self.kind].axial

    @property
    def pulls(self) -> bool:
        """True if it acts in tension only; along axes: upwards."""
        return KINDS[self.kind].pulls

    @property
    def joined(self) -> tuple[str, str]:
        """The names of both bodies, the first that of a block."""
        first, second = self.between
        return (second, first) if first == "foundation" else (first, second)
