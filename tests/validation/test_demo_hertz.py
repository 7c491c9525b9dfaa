"""The demo of Hertz's line contact, on a coarser mesh under two loads."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

Captured = pytest.CaptureFixture[str]

pytestmark = [pytest.mark.serial, pytest.mark.slow]


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    for package in ("dolfinx", "gmsh", "matplotlib"):
        pytest.importorskip(package)
    return importlib.import_module("demos.hertz.hertz")


@pytest.fixture(scope="module")
def contacts(demo: ModuleType) -> list[Any]:
    """The disc pressed to two half-widths, of 8 and 16 facets."""
    found: list[Any] = demo.press((0.5e-3, 1e-3), facets=16)
    return found


def test_its_checks_hold(
    demo: ModuleType,
    contacts: list[Any],
    tmp_path: Path,
    capsys: Captured,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Table, picture and four checks; the loads are met and rise fourfold."""
    monkeypatch.setattr(demo, "press", lambda: contacts)
    assert demo.main(["-o", str(tmp_path / "output")]) == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert output.out.count("holds:") == 4
    assert (tmp_path / "output" / "hertz.png").stat().st_size > 20_000
    first, second = contacts
    assert second.hertz.load == pytest.approx(4 * first.hertz.load)
    for one in contacts:
        assert one.found.resultant[0] == pytest.approx(one.hertz.load, rel=1e-6)


def test_its_checks_can_fail(demo: ModuleType, contacts: list[Any], capsys: Captured) -> None:
    """Hertz's contact of another load, with a peak and a width of its own."""
    other = replace(contacts[0], hertz=demo.closed_form(1.05 * contacts[0].hertz.load))
    assert demo.verdict("hertz", demo.checks([other, contacts[1]])) == 1
    line = capsys.readouterr().err
    assert line.startswith("hertz: check failed: P = 0.476 MN/m: peak pressure -2.")
    assert "half-width -2." in line and line.count("\n") == 1 and "1.81" not in line
