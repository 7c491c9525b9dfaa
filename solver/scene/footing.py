"""Where blocks start over what carries them; those that start beside it are refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

from solver.errors import SceneError
from solver.scene.checking import shown

if TYPE_CHECKING:
    from solver.scene.block import BlockSpec
    from solver.scene.scene import Scene


ROUND_OFF = 1e-9
"""Edges that miss one another by less than this part of a length touch."""


def tops(scene: Scene, block: BlockSpec) -> tuple[float, float] | None:
    """Width and thickness of the surface that carries a block, m; None: without ends."""
    carrier = scene.carrier_of(block)
    return scene.foundation.top if carrier is None else (carrier.width, carrier.thickness)


def offsets(scene: Scene, block: BlockSpec) -> list[tuple[str, float, float, float]]:
    """Along x, and in space y: the key of a block's offset, this, its length and its carrier's, m.

    Empty where what carries it has no ends.
    """
    top = tops(scene, block)
    if top is None:
        return []
    found = [("offset", block.offset, block.width, top[0])]
    if scene.dimension == 3:
        found.append(("offset_second", block.offset_second, block.thickness, top[1]))
    return found


def refuse_beside(scene: Scene) -> None:
    """Refuse blocks of which nothing is above what carries them at the start.

    Raises:
        SceneError: Names such a block, and how far its centre may be from that of its carrier.
    """
    for block in scene.blocks:
        for key, offset, own, carrier in offsets(scene, block):
            reach = (own + carrier) / 2
            if abs(offset) > reach * (1 + ROUND_OFF):
                allowed = (
                    f"between {-reach:g} and {reach:g}, so that {block.on} is below its bottom"
                )
                raise SceneError(f"{block.name}.{key}", shown(offset), allowed)


def beyond_edge(scene: Scene, block: BlockSpec) -> bool:
    """Whether the centre of a block is not above what carries it at the start."""
    return any(abs(offset) > carrier / 2 for _, offset, _, carrier in offsets(scene, block))
