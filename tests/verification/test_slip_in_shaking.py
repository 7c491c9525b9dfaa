"""Slip of squat blocks in shaking, with friction that falls with speed, against the reference."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.stability.families import FAMILIES
from benchmarks.stability.matrix import StabilityCase
from benchmarks.stability.verdict import judge
from solver.study.scenes import changed

pytestmark = pytest.mark.serial

FAMILY = next(family for family in FAMILIES if family.compared)

CHOSEN = {("default", "DC 20"), ("rigid, space", "DC 100")}
"""Scenes that stand for all that the stability study compares, up to 1.5 s."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [case for case in FAMILY.cases() if (case.row, case.column) in CHOSEN],
    ids=lambda case: case.name,
)
def test_slip_is_within_a_per_cent_of_the_reference(case: StabilityCase) -> None:
    short = replace(case, tables=changed(case.tables, {"time.end": 1.5}))
    verdict = judge(short, 120.0)
    assert (verdict.verdict, verdict.reason) == ("holds", "")
