"""Progress: what is shown where."""

from __future__ import annotations

import io
import sys
from typing import Any

import pytest

from solver.run import progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """No pauses between two lines or drawings."""
    monkeypatch.setattr(progress, "EVERY_SECONDS", 0.0)
    monkeypatch.setattr(progress, "EVERY_DRAWING", 0.0)


def drive(**options: Any) -> None:
    shown = progress.Progress(2.0, **options)
    for k in range(1, 101):
        shown.update(0.02 * k, 0.02, 3)
    shown.close()


@pytest.mark.usefixtures("hurried")
def test_lines_at_most_every_tenth(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    drive()
    lines = stream.getvalue().splitlines()
    assert 9 <= len(lines) <= 12
    assert "t 2 of 2 s (100 %), step 0.02 s, 3 iterations" in lines[-1]
    assert "s left" in lines[0]


def test_a_short_run_says_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    drive()
    assert len(stream.getvalue().splitlines()) == 1


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("options", [{"quiet": True}, {"rank": 1}])
def test_silence(monkeypatch: pytest.MonkeyPatch, options: dict[str, Any]) -> None:
    for stream in (io.StringIO(), Terminal()):
        monkeypatch.setattr(sys, "stderr", stream)
        drive(**options)
        assert stream.getvalue() == ""


@pytest.mark.usefixtures("hurried")
def test_a_bar_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("tqdm")
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    drive()
    text = stream.getvalue()
    assert "100%" in text
    assert "t 2/2 s, step 0.02 s, 3 iterations" in text
    assert "\r" in text


@pytest.mark.usefixtures("hurried")
def test_what_is_left_does_not_count_set_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A minute of set-up, a quarter of the steps in 5 s.

    The run goes on from 1 s of 5.
    """
    now, stream = [0.0], io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress.clock, "monotonic", lambda: now[0])
    shown = progress.Progress(5.0)
    now[0] = 60.0
    shown.begin(1.0)
    now[0] = 65.0
    shown.update(2.0, 0.01, 3)
    assert stream.getvalue().splitlines() == [
        "t 2 of 5 s (40 %), step 0.01 s, 3 iterations, 65 s spent, 15 s left",
    ]
