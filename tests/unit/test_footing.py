"""Blocks beside what carries them."""

from __future__ import annotations

import pytest
from scenes import BLOCK, OSCILLATOR, UPPER

from rockslip import Scene, parse_scene
from solver.errors import SceneError

PLATE = (
    '[foundation]\nkind = "elastic"\nwidth = 2.0\nheight = 0.2\nmass = 900.0\n'
    "young = 5.0e10\npoisson = 0.2\n"
)
END = "[time]\nend = 1.0\n"


def scene(text: str, *overrides: str) -> Scene:
    return parse_scene(f"{text}\n{END}", overrides=overrides)


def test_a_block_beside_its_carrier_is_refused() -> None:
    """Both are 0.25 m wide: at 0.25 m their edges are above one another."""
    assert scene(BLOCK + UPPER, "upper.offset=0.25").blocks[1].offset == 0.25
    for offset in (0.2501, -0.3):
        with pytest.raises(SceneError) as refused:
            scene(BLOCK + UPPER, f"upper.offset={offset}")
        assert str(refused.value) == (
            f"upper.offset: got {offset}, allowed between -0.25 and 0.25, "
            "so that block is below its bottom"
        )


def test_plates_have_ends_and_platforms_none() -> None:
    with pytest.raises(SceneError, match=r"^block.offset: got 1.5, allowed between -1.125 and"):
        scene(f"{BLOCK}\n{PLATE}", "block.offset=1.5")
    for endless in ("", OSCILLATOR):
        assert scene(f"{BLOCK}\n{endless}", "block.offset=1.5").blocks[0].offset == 1.5


def test_both_directions_count_in_space() -> None:
    """The plate is as deep as it is wide, the block 0.75 m deep."""
    text = f"dimension = 3\n{BLOCK}\n{PLATE}thickness = 2.0\n"
    assert scene(text, "block.offset=1.1", "block.offset_second=-1.3")
    with pytest.raises(SceneError, match=r"^block.offset_second: got 1.4, allowed between -1.375"):
        scene(text, "block.offset_second=1.4")
