"""Modes of a block: what it did over a run, in words.

Slide, turn and hop have one threshold: a hundredth of the width of the block, by which its base
slips, its corners go round the vertical, or all of it leaves what carries it.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.block import Block
from solver.results.motion import SMALLEST_WAY, BlockMotion
from solver.results.rocking import SMALLEST_SWING, overturned

#: A block rocks when one of its corners is lifted by more than this part of its width, in a swing.
SMALLEST_LIFT = 2e-4


def mode(block: Block, motion: BlockMotion, *, fell: bool = False) -> str:
    """Mode of a block: "fell", "overturned", or all of "slide", "turn", "rock", "hop" that it did.

    These are joined by hyphens in that order, as in "slide-rock"; "rest" where it did none.

    Args:
        block: Its shape.
        motion: What it did.
        fell: Whether it left what carried it, besides where `motion` says so.
    """
    if fell or motion.fell:
        return "fell"
    leaning = motion.shape
    if overturned(motion.lean, leaning.slenderness):
        return "overturned"
    swinging = np.abs(motion.angle) > SMALLEST_SWING * leaning.slenderness
    lifted = motion.lift > SMALLEST_LIFT * leaning.width
    round_corners = np.abs(motion.turn) * math.hypot(block.width, block.thickness) / 2
    found = {
        "slide": np.linalg.norm(motion.slip, axis=1) > SMALLEST_WAY * leaning.width,
        "turn": round_corners > SMALLEST_WAY * block.width,
        "rock": swinging & lifted,
        "hop": motion.flies,
    }
    return "-".join(word for word, rows in found.items() if np.any(rows)) or "rest"
