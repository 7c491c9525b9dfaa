"""Printed verdict of a program on its checks."""

from __future__ import annotations

import pytest

from demos.verdict import verdict

Captured = pytest.CaptureFixture[str]


def test_all_checks_hold(capsys: Captured) -> None:
    assert verdict("demo", [(True, "drift 1 mm"), (True, "gain 0")]) == 0
    output = capsys.readouterr()
    assert output.out == "  holds: drift 1 mm\n  holds: gain 0\n"
    assert output.err == ""


def test_checks_that_fail_are_one_line(capsys: Captured) -> None:
    assert verdict("demo", [(False, "drift 2 mm"), (True, "gain 0"), (False, "slip 1 mm")]) == 1
    output = capsys.readouterr()
    assert output.out == "  holds: gain 0\n"
    assert output.err == "demo: check failed: drift 2 mm; slip 1 mm\n"
