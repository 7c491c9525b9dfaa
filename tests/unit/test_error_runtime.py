"""The study of error against run time: ladders, limits, slopes, sentences, tables, bad input."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from benchmarks.error_runtime.findings import Beside, Findings, read_beside
from benchmarks.error_runtime.ladders import (
    NAMES,
    LadderFamily,
    Rung,
    RunOutcome,
    climb,
    coarsest_step,
    families,
)
from benchmarks.error_runtime.measures import check_patterns, chosen, words
from benchmarks.error_runtime.reference import Reference, limit, own_limit
from benchmarks.error_runtime.table import as_csv, everything, rows, text
from rockslip import Scene, parse_scene
from solver import cli
from solver.errors import SceneError
from solver.study.tables import write

ELASTIC = {
    "block": [
        {"width": 0.5, "height": 1.0, "mass": 300.0, "young": 1e9, "poisson": 0.2, "cells": [2, 4]}
    ],
    "time": {"end": 1.0, "step": 1e-3},
}


def made_up(size: float, *, order: float, seconds: float, status: str = "completed") -> RunOutcome:
    """A run whose answer, 2 when exact, errs by size^order."""
    value = np.array([2.0 + size**order])
    return RunOutcome(
        measures={"block.peak_slip_m": value} if status == "completed" else {},
        loop_s=seconds,
        setup_s=0.5,
        status=status,
        counts={"unknowns": 10},
    )


def family(name: str, order: float, cost: float, *, own: bool = True) -> LadderFamily:
    """Steps 0.4 to 0.05, each twice as dear as the one before."""
    rungs = tuple(
        Rung(
            setting=f"step {size:g} s",
            size=size,
            work=1 / size,
            solve=partial(made_up, size, order=order, seconds=cost / size),
        )
        for size in (0.4, 0.2, 0.1, 0.05)
    )
    return LadderFamily(name=name, size="step", rungs=rungs, own=own)


@pytest.fixture
def findings() -> Findings:
    """A first- and a second-order family, a rigid one, exact reference 2."""
    made = [family("step", 1, 1.0), family("better", 2, 2.0), family("rigid", 2, 0.1, own=False)]
    trials, left_out = climb(made, repeat=1, longest=100.0)
    assert not left_out
    return Findings(
        title="made up",
        machine="a machine",
        repeat=1,
        trials=trials,
        left_out=["step, step 0.025 s (about 40 s)"],
        references={
            "block.peak_slip_m": Reference(
                value=np.array([2.0]), uncertainty=1e-6, scale=2.0, source="by hand"
            )
        },
        names={"block.peak_slip_m": "peak slip"},
        others=[Beside(program="Other", measure="block.peak_slip_m", error=0.1, seconds=3.0)],
    )


MEASURE = "block.peak_slip_m"


def test_slopes(findings: Findings) -> None:
    first, second, _ = findings.families
    assert findings.slope(first, MEASURE).order == pytest.approx(1.0)
    assert findings.slope(second, MEASURE).order == pytest.approx(2.0)
    # the seconds are in proportion to 1/step
    assert findings.slope(first, MEASURE).time == pytest.approx(-1.0)
    assert findings.slope(second, MEASURE).time == pytest.approx(-2.0)


def test_errors_below_what_the_reference_can_tell_count_for_no_slope(findings: Findings) -> None:
    blurred = replace(findings.references[MEASURE], uncertainty=0.015)
    changed = replace(findings, references={MEASURE: blurred})
    # relative errors .08 .02 .005 .00125, of which one alone is clear of it, above 0.03
    assert math.isnan(changed.slope(changed.families[1], MEASURE).order)


def test_sentence_names_the_cheapest_run_that_is_good_enough(findings: Findings) -> None:
    # errors of "step": .2 .1 .05 .025; of the others .08 .02 .005 .00125
    assert findings.sentence(MEASURE) == (
        "For 1 % error of the peak slip use better, step 0.1 s; it takes 20 s "
        "(with rigid, step 0.1 s; it takes 1 s)."
    )
    rough = replace(findings, target=0.2)
    assert rough.sentence(MEASURE).startswith(
        "For 20 % error of the peak slip use step 0.4 s, the coarsest tried; it takes 2.5 s"
    )
    fine = replace(findings, target=1e-3)
    assert fine.sentence(MEASURE) == "For 0.1 % error of the peak slip no run is good enough."


def test_sentence_says_nothing_beyond_its_reference(findings: Findings) -> None:
    vague = replace(findings.references[MEASURE], uncertainty=0.03)
    changed = replace(findings, references={MEASURE: vague})
    assert "nothing can be said: the reference (by hand) is uncertain by 3 %" in changed.sentence(
        MEASURE
    )


def test_a_run_that_is_its_own_reference_has_no_error(findings: Findings) -> None:
    finest = findings.trials[3]
    own = replace(findings.references[MEASURE], value=finest.outcome.measures[MEASURE])
    changed = replace(findings, references={MEASURE: own})
    assert math.isnan(changed.error(finest, MEASURE))
    assert [error for _, error in changed.line(finest.family, MEASURE)] == pytest.approx(
        [0.175, 0.075, 0.025]
    )


def test_a_lucky_run_is_not_good_enough(findings: Findings) -> None:
    """The coarsest run errs by 0, the next one by a lot."""
    sizes, values = (0.4, 0.2, 0.1), (2.0, 3.0, 2.001)
    rungs = tuple(
        Rung(
            setting=f"step {size:g} s",
            size=size,
            work=1 / size,
            solve=lambda value=value, size=size: RunOutcome(
                measures={MEASURE: np.array([value])}, loop_s=1 / size, setup_s=0.0
            ),
        )
        for size, value in zip(sizes, values, strict=True)
    )
    trials, _ = climb(
        [LadderFamily(name="step", size="step", rungs=rungs)], repeat=1, longest=100.0
    )
    best = replace(findings, trials=trials).cheapest(MEASURE)
    assert best is not None and best.rung.setting == "step 0.1 s"


def test_climb_takes_the_median_and_leaves_out_what_takes_too_long() -> None:
    seconds = iter([9.0, 1.0, 5.0, 2.0, 4.0, 4.0, 4.0])  # the first is the warm-up
    rungs = tuple(
        Rung(
            setting=f"{work:g}",
            size=1 / work,
            work=work,
            solve=lambda: RunOutcome(measures={}, loop_s=next(seconds), setup_s=0.0),
        )
        for work in (1.0, 2.0, 8.0)
    )
    trials, left_out = climb(
        [LadderFamily(name="f", size="s", rungs=rungs)], repeat=3, longest=10.0
    )
    assert [trial.loop_s for trial in trials] == [2.0, 4.0]
    assert trials[0].seconds == (1.0, 5.0, 2.0)
    assert left_out == ["f, 8 (about 16 s)"]


def test_limit_of_a_ladder() -> None:
    first = limit([np.array([1 + 0.4]), np.array([1 + 0.2]), np.array([1 + 0.1])])
    assert first.converges
    assert first.value == pytest.approx([1.0])
    assert first.uncertainty == pytest.approx(0.1)
    second = limit([np.array([1 + h**2, 2 - h**2]) for h in (0.4, 0.2, 0.1)])
    assert second.value == pytest.approx([1.0, 2.0])
    # third order is not counted on: 2nd leaves a part of the error, well within the uncertainty
    third = limit([np.array([1 + h**3]) for h in (0.4, 0.2, 0.1)])
    assert abs(third.value[0] - 1) < third.uncertainty


@pytest.mark.parametrize(
    "values, uncertainty",
    [
        ([1.0, 1.1, 1.2], 0.1),  # does not settle
        ([1.0, 1.4, 1.3], 0.4),  # turns back
        ([1.0, 1.1], 0.1),  # tells no order
    ],
)
def test_limit_of_a_ladder_that_does_not_converge(values: list[float], uncertainty: float) -> None:
    found = limit([np.array([value]) for value in values])
    assert not found.converges
    assert found.value[0] == values[-1]
    assert found.uncertainty == pytest.approx(uncertainty)


@pytest.mark.parametrize("answer, uncertainty", [(2.01, 0.05), (2.4, 0.4)])
def test_adaptive_steps_check_the_limit_of_fixed_ones(answer: float, uncertainty: float) -> None:
    """The steps go to 2, uncertain by 0.05; adaptive ones somewhere else."""
    strict = Rung(
        setting="tolerance 1e-9", size=1e-9, work=1.0,
        solve=lambda: RunOutcome(measures={MEASURE: np.array([answer])}, loop_s=1.0, setup_s=0.0),
    )  # fmt: skip
    adaptive = LadderFamily(name="adaptive", size="tolerance", rungs=(strict,))
    trials, _ = climb([family("step", 1, 1.0), adaptive], repeat=1, longest=100.0)
    found = own_limit(trials, MEASURE)
    assert found is not None
    assert found.value[0] == pytest.approx(2.0)
    assert found.uncertainty == pytest.approx(uncertainty / 2.0)
    assert ("not converged" in found.source) == (uncertainty > 0.05)


def test_adaptive_steps_have_a_limit_that_fixed_ones_do_not_see() -> None:
    """Fixed steps go to 2, uncertain by 0.05; adaptive ones to 2.4 with 2.56, 2.44 and 2.41."""
    rungs = tuple(
        Rung(
            setting="", size=tolerance, work=1.0,
            solve=partial(
                RunOutcome, measures={MEASURE: np.array([2.4 + tolerance])}, loop_s=1.0, setup_s=0.0
            ),
        )
        for tolerance in (0.16, 0.04, 0.01)
    )  # fmt: skip
    adaptive = LadderFamily(name="adaptive", size="tolerance", rungs=rungs)
    trials, _ = climb([family("step", 1, 1.0), adaptive], repeat=1, longest=100.0)
    found = own_limit(trials, MEASURE)
    assert found is not None
    assert found.value[0] == pytest.approx(2.4)
    assert found.uncertainty == pytest.approx(0.01 / 2.4)
    assert found.source == "limit of its own adaptive steps"


def test_limit_of_steps_and_meshes_together() -> None:
    """Answer 2 + step + h^2 in ladders through step 0.1, h 1: the limit of both is 2."""

    def outcome(step: float, h: float) -> RunOutcome:
        return RunOutcome(measures={MEASURE: np.array([2 + step + h**2])}, loop_s=1.0, setup_s=0.0)

    def rungs(pairs: list[tuple[float, float]], which: int) -> tuple[Rung, ...]:
        return tuple(
            Rung(setting="", size=pair[which], work=1.0, solve=partial(outcome, *pair))
            for pair in pairs
        )

    ladder = LadderFamily(
        name="step", size="step", rungs=rungs([(s, 1.0) for s in (0.2, 0.1, 0.05)], 0)
    )
    meshes = LadderFamily(
        name="mesh", size="cells", rungs=rungs([(0.1, h) for h in (2.0, 1.0, 0.5)], 1)
    )
    trials, _ = climb([ladder, meshes], repeat=1, longest=100.0)
    found = own_limit(trials, MEASURE)
    assert found is not None
    assert found.value[0] == pytest.approx(2.0)
    assert found.uncertainty == pytest.approx((0.05 + 0.25) / 2.0)


def test_families_of_an_elastic_scene() -> None:
    scene = parse_scene(ELASTIC)
    made = {f.name: f for f in families(scene, NAMES, 4, _never)}
    assert list(made) == [
        "step", "adaptive", "mesh", "degree 2", "points gauss",
        "rho_inf 0", "rho_inf 0.5", "rho_inf 1", "rigid blocks",
    ]  # fmt: skip
    assert [rung.size for rung in made["step"].rungs] == [4e-3, 2e-3, 1e-3, 5e-4]
    assert [rung.setting for rung in made["mesh"].rungs] == [
        "cells 1 x 2", "cells 2 x 4", "cells 4 x 8",
    ]  # fmt: skip
    assert [rung.work for rung in made["mesh"].rungs] == [0.25, 1.0, 4.0]
    assert len(made["rho_inf 0"].rungs) == 2
    assert not made["rigid blocks"].own
    assert subject(made["points gauss"].rungs[0]).contact.points == "gauss"
    assert subject(made["rho_inf 0"].rungs[0]).time.rho_inf == 0.0
    assert subject(made["degree 2"].rungs[0]).blocks[0].degree == 2
    assert subject(made["rigid blocks"].rungs[0]).is_rigid
    finest = subject(made["step"].rungs[3]).time
    assert (finest.step, finest.smallest) == (5e-4, 5e-4 / 1024)


def test_adaptive_steps_are_a_ladder_of_tolerances() -> None:
    made = families(parse_scene(ELASTIC), ["adaptive"], 4, _never)
    spans = [subject(rung).time for rung in made[1].rungs]
    assert [span.tolerance for span in spans] == pytest.approx([1.6e-2, 4e-3, 1e-3, 2.5e-4])
    assert {(span.adaptive, span.step, span.largest) for span in spans} == {(True, 1e-3, 4e-3)}
    asked = {"end": 1.0, "step": 1e-3, "adaptive": True, "tolerance": 1e-5}
    made = families(parse_scene(ELASTIC | {"time": asked}), ["adaptive", "mesh"], 4, _never)
    assert [rung.size for rung in made[1].rungs] == pytest.approx([1.6e-4, 4e-5, 1e-5, 2.5e-6])
    others = [subject(rung).time for family in (made[0], made[2]) for rung in family.rungs]
    assert not any(span.adaptive for span in others)  # the other ladders have fixed steps


def test_families_of_a_rigid_scene() -> None:
    block = {"width": 0.5, "height": 1.0, "mass": 300.0, "model": "rigid"}
    made = families(parse_scene(ELASTIC | {"block": [block]}), NAMES, 3, _never)
    assert [f.name for f in made] == ["step"]
    with_elasticity = ELASTIC["block"][0] | {"model": "rigid"}
    made = families(parse_scene(ELASTIC | {"block": [with_elasticity]}), NAMES, 3, _never)
    assert [f.name for f in made] == ["step", "elastic blocks"]


def test_meshes_of_what_carries_the_blocks_are_refined_too() -> None:
    plate = {
        "kind": "elastic", "width": 2.0, "height": 0.2, "density": 2500.0, "young": 1e9,
        "poisson": 0.2, "cells": [8, 2],
    }  # fmt: skip
    made = families(parse_scene(ELASTIC | {"foundation": plate}), ["mesh"], 3, _never)
    assert [subject(r).foundation.cells for r in made[1].rungs] == [(4, 1), (8, 2), (16, 4)]


def test_ladders_stay_within_the_run() -> None:
    short = parse_scene(ELASTIC | {"time": {"end": 2e-3, "step": 1e-3}})
    assert coarsest_step(short) == 2e-3


def _never(scene: Scene) -> RunOutcome:
    raise AssertionError("nothing is run here")


def subject(rung: Rung) -> Scene:
    """The scene of a rung."""
    solve: partial[RunOutcome] = rung.solve  # type: ignore[assignment]
    return solve.args[0]


def test_measures_by_short_names() -> None:
    there = ["lower.first_impact_s", "upper.first_impact_s", "platform.peak_drift_m"]
    assert chosen(there, []) == (there, [])
    assert chosen(there, ["peak_drift", "first_impact"]) == ([there[2], *there[:2]], [])
    assert chosen(there, ["peak_slip", "upper.first_impact_s"]) == ([there[1]], ["peak_slip"])
    assert words(there[0], ("lower", "upper")) == "time of the first impact of lower"
    assert words(there[2]) == "peak drift of the platform"
    check_patterns([*there, "peak_drift", "energy.lost_fraction"])


def test_table_holds_every_run(findings: Findings, tmp_path: Path) -> None:
    write(tmp_path / "errors.csv", as_csv(findings))
    with (tmp_path / "errors.csv").open(encoding="utf-8") as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == 12
    row = table[1]
    assert (row["family"], row["setting"], row["status"]) == ("step", "step 0.2 s", "completed")
    assert float(row["loop_s"]) == 5.0
    assert float(row["setup_s"]) == 0.5
    assert float(row[MEASURE]) == pytest.approx(2.2)
    assert float(row[f"error.{MEASURE}"]) == pytest.approx(0.1)
    assert row["unknowns"] == "10"


def test_runs_that_failed_stand_in_the_table_without_errors(findings: Findings) -> None:
    failing = Rung(
        setting="step 1 s", size=1.0, work=1.0,
        solve=partial(made_up, 1.0, order=1, seconds=1.0, status="not converged"),
    )  # fmt: skip
    trials, _ = climb(
        [LadderFamily(name="bad", size="step", rungs=(failing,))], repeat=3, longest=9.0
    )
    changed = replace(findings, trials=[*findings.trials, *trials])
    row = rows(changed)[-1]
    assert row["status"] == "not converged"
    assert math.isnan(row[f"error.{MEASURE}"])
    assert "bad     step 1 s" in text(changed)


def test_json_and_text(findings: Findings, tmp_path: Path) -> None:
    write(tmp_path / "errors.json", everything(findings))
    known = json.loads((tmp_path / "errors.json").read_text(encoding="utf-8"))
    assert known["references"][MEASURE]["value"] == 2.0
    assert known["references"][MEASURE]["own_limit_differs_by"] is None
    assert known["slopes"][MEASURE]["better"]["order"] == pytest.approx(2.0)
    assert known["sentences"][MEASURE] == findings.sentence(MEASURE)
    assert len(known["runs"]) == 12
    said = text(findings)
    assert "peak slip (block.peak_slip_m): 2, by hand, uncertain by 1.0e-06" in said
    assert "2.00 (-2.00)" in said
    assert findings.sentence(MEASURE) in said
    assert "left out: step, step 0.025 s (about 40 s)" in said
    assert "busy" not in said


def test_text_tells_of_a_busy_machine(findings: Findings) -> None:
    trial = findings.trials[0]
    slow = replace(trial, outcome=replace(trial.outcome, counts={"processor_share": 0.4}))
    assert "runs had 40 to 40 % of a processor" in text(replace(findings, trials=[slow]))


def test_picture(findings: Findings, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from matplotlib.figure import Figure

    from benchmarks.error_runtime.picture import draw

    figure: Figure = draw(findings, [MEASURE])
    axes = figure.axes[0]
    labels = [line.get_label() for line in axes.get_lines()]
    assert labels[:4] == ["step  -1.0; 1.0", "better  -2.0; 2.0", "rigid  -2.0; 2.0", "Other"]
    x, y = axes.get_lines()[1].get_data()
    np.testing.assert_allclose(x, [5, 10, 20, 40])
    np.testing.assert_allclose(y, [0.08, 0.02, 0.005, 0.00125])
    assert axes.get_lines()[3].get_data() == ([3.0], [0.1])


def test_points_of_other_programs(tmp_path: Path) -> None:
    file = tmp_path / "beside.csv"
    head = "# a comment\nprogram,measure,error,seconds,note\n"
    file.write_text(f'{head}A,block.x,-0.02,3,"one, two"\nB,y,1e-3,,\n')
    first, second = read_beside(file)
    assert first == Beside(program="A", measure="block.x", error=0.02, seconds=3.0, note="one, two")
    assert second.error == 1e-3 and math.isnan(second.seconds)


@pytest.mark.parametrize(
    "content, where",
    [
        ("program,measure\n", "line 1"),
        ("program,measure,error,seconds,note\nA,x,much,3,\n", "line 2"),
        ("program,measure,error,seconds,note\n#\nA,x,0.1,-3,\n", "line 3"),
        ("program,measure,error,seconds,note\nA,x,0.1\n", "line 2"),
        ("program,measure,error,seconds,note\nA,x,nan,3,\n", "line 2"),
    ],
)
def test_bad_points_of_other_programs(tmp_path: Path, content: str, where: str) -> None:
    file = tmp_path / "beside.csv"
    file.write_text(content)
    with pytest.raises(SceneError, match=where):
        read_beside(file)


@pytest.mark.parametrize(
    "words, named",
    [
        (["--rungs", "1"], "--rungs"),
        (["--repeat", "0"], "--repeat"),
        (["--longest", "0"], "--longest"),
        (["--target", "nan"], "--target"),
        (["--families", "colour"], "--families"),
        (["--measures", "first_impakt"], "first_impact_s"),
        (["--beside", "none.csv"], "--beside"),
        (["--set", "time.stop=1"], "time.stop"),
    ],
)
def test_bad_options(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], named: str
) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(
        "[[block]]\nwidth = 1\nheight = 2\nmass = 3\nmodel = 'rigid'\n"
        "[time]\nend = 1.0\nstep = 0.01\n"
    )
    folder = tmp_path / "out"
    assert cli.main(["study", "error-runtime", str(scene), "-o", str(folder), *words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and named in said
    assert not folder.exists()
