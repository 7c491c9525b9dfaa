"""Cautions: when they are given, and what they advise."""

from __future__ import annotations

import math

import pytest
from scenes import BLOCK

from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.results.cautions import (
    cautions_of_run,
    cautions_of_scene,
    loss_shares,
    suggested_damping,
    unresolved_share,
)


def scene(*overrides: str) -> Scene:
    """The paper's block, which is meshed, with adaptive steps."""
    return parse_scene(f"{BLOCK}\n[time]\nend = 2.0\n", overrides=overrides)


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
        (loss(0.0, 1.0), (), ("100 %", "damping.stiffness")),
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

    assert told("damping.stiffness=3e-5") == []
    assert told('block.model="rigid"') == []
    assert told("contact.damping=0.1") == told("contact.damping=0.1", "time.step=1e-4") == []
    (coarse,) = told("contact.damping=0.1", "time.step=2e-4")
    assert "time.step" in coarse
    (undamped,) = told()
    assert "damping.stiffness" in undamped and "time.step" not in undamped
    (coarse,) = told("time.step=1e-3", "damping.stiffness=3e-5")
    assert "time.step" in coarse
    assert told("time.step=1e-5", "damping.stiffness=3e-5") == []
    motion = ('motion.kind="half_sine"', "motion.amplitude_g=0.3", "motion.duration=3.0")
    (early,) = told("damping.stiffness=3e-5", *motion)
    assert "before its motion does at 3 s" in early


def test_the_suggested_damping_is_two_percent_of_critical() -> None:
    """A cantilever of the paper's block bends at 174 times a second, by Euler and Bernoulli."""
    block = scene().blocks[0]
    assert block.young is not None
    radius = block.width / math.sqrt(12)
    frequency = 3.516 * math.sqrt(block.young / block.shape.density) * radius / block.height**2
    assert frequency / (2 * math.pi) == pytest.approx(174, rel=0.01)
    assert suggested_damping(block) * frequency / 2 == pytest.approx(0.02, rel=0.05)
