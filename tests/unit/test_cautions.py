"""Cautions: when they are given, and what they advise."""

from __future__ import annotations

from pathlib import Path

import pytest
from scenes import BLOCK, OSCILLATOR

from rockslip import Scene, parse_scene
from solver.excitation.motion import read_ground
from solver.results.cautions import (
    cautions_of_impacts,
    cautions_of_input,
    cautions_of_run,
    cautions_of_scene,
    cautions_of_steps,
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
    assert loss_shares(loss(3.0, 1.0, 4.0), 10.0)["friction"] == pytest.approx(0.5)
    assert loss_shares(loss(0.0, 0.0), 10.0) == {}
    assert loss_shares(loss(1e-12, 0.0), 10.0) == {}


@pytest.mark.parametrize(
    ("lost", "overrides", "words"),
    [
        (loss(9.0, 1.0), (), ()),
        (loss(0.0, 1.0), ("damping.stiffness=0",), ("100 %", "damping.stiffness")),
        (loss(0.0, 1.0), ("time.step=1e-3",), ("100 %", "time.step")),
        (loss(7.0, 3.0), ("damping.stiffness=3e-5", "time.step=1e-3"), ("30 %", "time.step")),
        (loss(0.0, 1.0), ("time.tolerance=1",), ("100 %", "leave out time.tolerance")),
        (loss(0.0, 1e-3), (), ()),  # too little to be judged
        (loss(0.0, 1.0), ('block.model="rigid"',), ()),  # that loss is Housner's
    ],
)
def test_of_a_run(
    lost: dict[str, float], overrides: tuple[str, ...], words: tuple[str, ...]
) -> None:
    found = [*cautions_of_run(scene(*overrides), lost, 10.0)]
    assert len(found) == bool(words)
    assert all(word in found[0] for word in words)


@pytest.mark.parametrize("plate", [{"meshed": True}, {"meshed": False}, {"support": "bottom"}])
def test_what_the_law_of_impact_takes_is_no_loss_of_steps(plate: dict[str, object]) -> None:
    """A rigid block on a plate that is held, meshed or not, loses what Housner's does."""
    size = {"width": 4.0, "height": 0.3, "young": 5e10, "poisson": 0.2, "density": 2400.0}
    block = {"name": "a", "model": "rigid", "width": 0.5, "height": 1.0, "mass": 1200.0}
    tables = {"block": [block], "foundation": {"kind": "elastic"} | size | plate}
    alone = parse_scene(tables | {"time": {"end": 1.0}})
    assert bool([*cautions_of_run(alone, loss(0.0, 1.0), 10.0)]) == ("support" in plate)
    other = block | {"name": "b", "model": "elastic", "offset": 1.0, "young": 5e10, "poisson": 0.2}
    both = parse_scene(tables | {"block": [block, other], "time": {"end": 1.0}})
    (told,) = cautions_of_run(both, loss(0.0, 1.0), 10.0)
    assert ("(or, for a, to the law of impact)" in told) == ("support" not in plate)


def test_what_dashpots_of_contact_take_is_resolved() -> None:
    lost = loss(0.0, 1.0) | {"contact_damping_J": 9.0}
    assert unresolved_share(lost) == pytest.approx(0.1)
    assert [*cautions_of_run(scene("contact.damping=0.1"), lost, 10.0)] == []


def test_of_a_scene() -> None:
    def told(*overrides: str) -> list[str]:
        asked = scene(*overrides)
        return [*cautions_of_scene(asked, read_ground(asked))]

    assert told() == told("damping.stiffness=3e-5") == []
    assert told('block.model="rigid"') == []
    on_dashpots = ("damping.stiffness=0", "contact.damping=0.1")
    assert told(*on_dashpots) == told(*on_dashpots, "time.step=1e-4") == []
    (coarse,) = told(*on_dashpots, "time.step=2e-4")
    assert "time.step" in coarse
    for nothing in ("damping.stiffness=0", "block.damping={}"):
        (undamped,) = told(nothing)
        assert "by default 3.74e-05 s" in undamped and "time.step" not in undamped
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


def told_of_input(*overrides: str) -> list[str]:
    """Cautions that runs repeat."""
    asked = scene(*overrides)
    return cautions_of_input(asked, read_ground(asked))


PULSE = ("motion.kind='half_sine'", "motion.duration=0.3")


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (("block.mass=0.5",), "block weighs 2.67 kg/m3: look at its lengths"),
        (("block.mass=1e4",), "block weighs 5.33e+04 kg/m3: look at its lengths"),
        ((*PULSE, "motion.amplitude_g=4.9"), "motion reaches 4.9 g: more than 3 g has hardly been"),
        (
            (*PULSE, "motion.amplitude_g=0.3", "motion.start=1.9"),
            "the run ends at 2 s, before its motion does at 2.2 s",
        ),
        (
            (*PULSE, "motion.amplitude_g=0.3", "motion.start=9"),
            "motion begins at 9 s, after the run ends at 2 s",
        ),
        (("gravity=981.0",), "gravity is 981 m/s2, 100 g: look at its unit"),
        (("contact.friction={static=0.5, dynamic=0.4}",), "friction of block falls from 0.5 to"),
    ],
)
def test_of_input_that_looks_like_a_mistake(overrides: tuple[str, ...], words: str) -> None:
    (text,) = told_of_input(*overrides)
    assert text.startswith(words)


def test_of_input_that_does_not() -> None:
    assert told_of_input() == told_of_input(*PULSE, "motion.amplitude_g=-2.9") == []


PLATE = """[foundation]
kind = "elastic"
width = 2.0
height = 0.2
mass = 900.0
young = 5.0e10
poisson = 0.2
support = "bottom"
"""


@pytest.mark.parametrize(
    ("overrides", "warned"),
    [
        ((), True),
        (("foundation.damping.stiffness=1e-4",), False),
        (("damping.stiffness=1e-4",), False),
        (("foundation.damping_ratio=0.02",), False),
        (("foundation.support='fixed'",), False),
        (("foundation.support='rollers'", "foundation.period=0.4"), True),
    ],
)
def test_of_foundations_that_nothing_damps(overrides: tuple[str, ...], warned: bool) -> None:
    asked = parse_scene(f"{BLOCK}\n{PLATE}[time]\nend = 2.0\n", overrides=overrides)
    found = [*cautions_of_scene(asked, read_ground(asked))]
    assert any("nothing damps the foundation" in text for text in found) == warned


@pytest.mark.parametrize(("ratio", "warned"), [(1.994, True), (0.99, False), (None, False)])
def test_of_impacts_that_a_block_comes_faster_from(ratio: float | None, warned: bool) -> None:
    asked = parse_scene(f"{BLOCK}\n{PLATE}[time]\nend = 2.0\n")
    read = {} if ratio is None else {"ratio": ratio}
    impacts = [{"time_s": 0.2, "restitution": 0.9}, {"time_s": 0.5, "restitution": None} | read]
    found = [*cautions_of_impacts(asked, {"block": {"impacts": impacts}})]
    assert len(found) == warned
    assert not warned or "impact at 0.5 s 1.99 times as fast" in found[0]
    # Platforms that move as a whole give and take energy.
    moving = parse_scene(f"{BLOCK}\n{OSCILLATOR}[time]\nend = 2.0\n")
    assert [*cautions_of_impacts(moving, {"block": {"impacts": impacts}})] == []


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


def test_of_steps_that_may_not_be_short_enough() -> None:
    asked = scene("time.smallest=1e-4")
    assert [*cautions_of_steps(asked, {"steps": 100, "coarse_steps": 1})] == []
    assert [*cautions_of_steps(asked, {"steps": 100})] == []
    (text,) = cautions_of_steps(asked, {"steps": 100, "coarse_steps": 2})
    assert text.startswith("2 of 100 steps miss time.tolerance, since time.smallest = 0.0001 s")


def test_units_of_materials() -> None:
    plate = {
        **{"kind": "elastic", "support": "bottom", "width": 3.0, "height": 0.5},
        **{"density": 2.5, "young": 3e5, "poisson": 0.2},
    }
    block = {"width": 0.3, "height": 0.2, "mass": 50.0, "young": 210000.0, "poisson": 0.2}
    scene = parse_scene({"block": [block], "foundation": plate, "time": {"end": 1.0, "step": 1e-3}})
    found = cautions_of_input(scene, read_ground(scene))
    assert "the foundation weighs 2.5 kg/m3" in found[0]
    assert [text.split(" has ")[0] for text in found[1:]] == ["block", "the foundation"]
    assert "2.1e+05 Pa" in found[1]


def test_what_steps_lost_is_unresolved() -> None:
    """1 J in undamped contact and 3 J by steps, of 10 J that impacts lost."""
    lost = loss(6.0, 1.0, friction=100.0) | {"numerical_J": 3.0}
    assert unresolved_share(lost) == pytest.approx(0.4)
    found = [*cautions_of_run(scene(), lost, 10.0)]
    assert len(found) == 1 and found[0].startswith("40 %")
