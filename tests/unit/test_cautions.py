"""Cautions: when they are given, and what they advise."""

from __future__ import annotations

from pathlib import Path

import pytest
from scenes import BLOCK

from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.results.cautions import (
    cautions_of_input,
    cautions_of_run,
    cautions_of_scene,
    loss_shares,
    unresolved_share,
)


def scene(*overrides: str) -> Scene:
    """The paper's block, which is meshed, with adaptive steps."""
    return parse_scene(f"{BLOCK}\n[time]\nend = 2.0\n", overrides=overrides)


QUICK = ("motion.kind='half_sine'", "motion.amplitude_g=0.3", "motion.duration=0.004")


def loss(damping: float, contact: float, friction: float = 0.0) -> dict[str, float]:
    """Losses of a run, J."""
    return {"friction_J": friction, "damping_J": damping, "contact_J": contact, "numerical_J": 0.0}


def test_friction_is_no_loss_of_impacts() -> None:
    assert unresolved_share(loss(3.0, 1.0, friction=100.0)) == pytest.approx(0.25)
    assert unresolved_share(loss(0.0, 0.0, friction=1.0)) == 0.0
    assert loss_shares(loss(3.0, 1.0, 4.0))["friction"] == pytest.approx(0.5)
    assert loss_shares(loss(0.0, 0.0)) == {}


@pytest.mark.parametrize(
    ("lost", "overrides", "words"),
    [
        (loss(9.0, 1.0), (), ()),
        (loss(0.0, 1.0), ("damping.stiffness=0",), ("100 %", "damping.stiffness")),
        (loss(0.0, 1.0), ("time.step=1e-3",), ("100 %", "time.step")),
        (loss(7.0, 3.0), ("damping.stiffness=3e-5", "time.step=1e-3"), ("30 %", "time.step")),
        (loss(0.0, 1e-3), (), ()),  # too little to be judged
        (loss(0.0, 1.0), ('block.model="rigid"',), ()),  # that loss is Housner's
    ],
)
def test_of_a_run(
    lost: dict[str, float], overrides: tuple[str, ...], words: tuple[str, ...]
) -> None:
    found = cautions_of_run(scene(*overrides), lost, 10.0)
    assert len(found) == bool(words)
    assert all(word in found[0] for word in words)


def test_what_dashpots_of_contact_take_is_resolved() -> None:
    lost = loss(0.0, 1.0) | {"contact_damping_J": 9.0}
    assert unresolved_share(lost) == pytest.approx(0.1)
    assert cautions_of_run(scene("contact.damping=0.1"), lost, 10.0) == []


def test_of_a_scene() -> None:
    def told(*overrides: str) -> list[str]:
        asked = scene(*overrides)
        return cautions_of_scene(asked, read_ground(asked))

    assert told() == told("damping.stiffness=3e-5") == []
    assert told('block.model="rigid"') == []
    on_dashpots = ("damping.stiffness=0", "contact.damping=0.1")
    assert told(*on_dashpots) == told(*on_dashpots, "time.step=1e-4") == []
    (coarse,) = told(*on_dashpots, "time.step=2e-4")
    assert "time.step" in coarse
    for nothing in ("damping.stiffness=0", "block.damping={}"):
        (undamped,) = told(nothing)
        assert "2 % of critical 3.65e-05" in undamped and "time.step" not in undamped
    (coarse,) = told("time.step=1e-3", "damping.stiffness=3e-5")
    assert "time.step" in coarse
    assert told("time.step=1e-5", "damping.stiffness=3e-5") == []
    motion = ('motion.kind="half_sine"', "motion.amplitude_g=0.3", "motion.duration=3.0")
    (early,) = told("damping.stiffness=3e-5", *motion)
    assert "before its motion does at 3 s" in early


def test_damping_that_no_body_has() -> None:
    """The copy of a scene has the default written out for each block: [damping] changes nothing."""
    copy = parse_scene(scene().to_dict(), overrides=["damping.stiffness=1e-4"])
    assert copy.damping_of(copy.blocks[0]) == scene().blocks[0].damping
    (unused,) = cautions_of_scene(copy, read_ground(copy))
    assert unused == "[damping] applies to no body: each block has its own damping"


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (("time.step=1e-3",), ()),
        (("time.step=0.05",), ("steps of 0.05 s", "time.step = 0.01", "200 steps instead of 40")),
        (("time.step=0.05", "block.tilt_deg=13.5"), ()),  # such a swing takes a second
        (("time.step=0.05", "block.tilt_deg=3"), ("3.8 in the 0.191 s of a swing of block",)),
        (("time.step=1e-3", *QUICK), ("4 in the 0.004 s of [motion], kind = half_sine",)),
        (("time.step=1e-3", "time.adaptive=true", "time.largest=0.1"), ("time.largest = 0.01",)),
        (QUICK, ()),  # the steps that the program takes see all
    ],
)
def test_of_steps(overrides: tuple[str, ...], words: tuple[str, ...]) -> None:
    asked = scene("damping.stiffness=3e-5", 'block.model="elastic"', *overrides)
    found = [text for text in cautions_of_input(asked, read_ground(asked)) if "see" in text]
    assert len(found) == bool(words)
    assert all(word in found[0] for word in words)


def test_of_motions_that_no_ground_has_made(tmp_path: Path) -> None:
    (tmp_path / "m.txt").write_text("0\n2\n3.2\n1\n0")
    file = f"motion.file={str(tmp_path / 'm.txt')!r}"
    given = ("time.end=1", "motion.kind='record'", "motion.dt=0.02", file)
    asked = scene(*given, 'motion.units="g"')
    (text,) = cautions_of_input(asked, read_ground(asked))
    assert text.startswith(f"motion reaches 3.2 g, in line 3 of {tmp_path}/m.txt: more than 3 g")
    weaker = scene(
        "time.end=1", "motion.kind='record'", "motion.dt=0.02", 'motion.units="m/s2"', file
    )
    assert cautions_of_input(weaker, read_ground(weaker)) == []
