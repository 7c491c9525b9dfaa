"""Slip of squat blocks in shaking, with friction that falls with speed, against the reference."""

from __future__ import annotations

import pytest

from benchmarks.stability.families import FAMILIES
from benchmarks.stability.matrix import StabilityCase
from benchmarks.stability.verdict import judge

pytestmark = pytest.mark.serial

FAMILY = next(family for family in FAMILIES if family.compared)

QUICK = {("default", "DC 20"), ("rigid", "DC 5"), ("rigid, space", "DC 100")}
"""Scenes that stand for the others where there is little time."""


def cases() -> list[object]:
    """The family that the stability study compares, without its finest steps."""
    return [
        pytest.param(
            case, id=case.name, marks=() if (case.row, case.column) in QUICK else pytest.mark.slow
        )
        for case in FAMILY.cases()
        if case.row != "dt 2e-4"
    ]


@pytest.mark.parametrize("case", cases())
def test_slip_is_within_a_per_cent_of_the_reference(case: StabilityCase) -> None:
    verdict = judge(case, 120.0)
    assert (verdict.verdict, verdict.reason) == ("holds", "")
