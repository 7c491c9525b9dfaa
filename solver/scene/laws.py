"""Laws of contact of any two bodies of a scene."""

from __future__ import annotations

from collections.abc import Sequence

from solver.scene.block import BlockSpec
from solver.scene.contact import FrictionSpec, PairSpec

GROUND = "foundation"
"""Name of what carries the blocks: the ground, a platform, a plate or a frame."""

Law = tuple[FrictionSpec, float]
"""Friction, and restitution: 0 for plastic impacts."""


class Laws:
    """Friction and restitution of any two bodies of a scene, by their names."""

    def __init__(
        self,
        blocks: Sequence[BlockSpec],
        pairs: Sequence[PairSpec],
        friction: float | FrictionSpec,
    ) -> None:
        """Gather what is said of blocks and pairs; `friction` is for blocks without their own."""
        self._blocks = {block.name: block for block in blocks}
        self._places = {block.name: place for place, block in enumerate(blocks)}
        self._pairs = {frozenset(pair.between): pair for pair in pairs}
        self._friction = friction
        self._own: dict[str, Law] = {}

    def between(self, first: str, second: str) -> Law:
        """The law of two bodies, which need not touch at the start.

        What their `[[pair]]` gives. Else what the block has of which the other one is a carrier, or
        which meets the foundation. Else, of neighbours, the friction with the smaller static
        coefficient, where both are the same that of the earlier one, and the smaller restitution.

        Args:
            first: Name of a block, or "foundation".
            second: That of another body.

        Raises:
            ValueError: They are not two bodies of the scene.
        """
        names = {first, second}
        if len(names) != 2 or not names - {GROUND} <= self._blocks.keys():
            raise ValueError(f"{first} and {second} are not two bodies of the scene")
        friction, restitution = self._by_blocks(first, second)
        pair = self._pairs.get(frozenset(names))
        if pair is not None and pair.friction is not None:
            friction = FrictionSpec.of(pair.friction)
        if pair is not None and pair.restitution is not None:
            restitution = pair.restitution
        return friction, restitution

    def _by_blocks(self, first: str, second: str) -> Law:
        """The law of two bodies without their pair."""
        for upper, lower in ((first, second), (second, first)):
            if lower == GROUND or (upper != GROUND and lower in self._blocks[upper].carriers):
                return self._law_of(upper)
        both = [
            self._law_of(name) for name in sorted((first, second), key=self._places.__getitem__)
        ]
        friction = min((law[0] for law in both), key=lambda friction: friction.static)
        return friction, min(law[1] for law in both)

    def _law_of(self, name: str) -> Law:
        """The law of a block."""
        if name not in self._own:
            block = self._blocks[name]
            friction = self._friction if block.friction is None else block.friction
            self._own[name] = FrictionSpec.of(friction), block.restitution or 0.0
        return self._own[name]
