"""History: what is appended is what is read back."""

from __future__ import annotations

import errno
import math
import tempfile
from pathlib import Path

import numpy as np
import pytest

from rockslip import History, parse_scene
from solver.errors import SceneError
from solver.history.columns import columns
from solver.history.history import BLOCK, scene_columns


def test_columns_follow_the_interface() -> None:
    """Names and order of the columns that users read."""
    names = columns(["top", "base"])
    assert names[:5] == (
        "time_s",
        "step_s",
        "newton_iterations",
        "contact_points_closed",
        "base.acceleration_m_s2",
    )
    assert names[5:7] == ("top.angle_rad", "top.angular_velocity_rad_s")
    assert names[15] == "base.angle_rad"
    assert names[-2:] == ("energy.total_J", "energy.ledger_error_J")
    assert len(names) == 5 + 2 * 10 + 13


def test_columns_in_space_and_of_a_platform() -> None:
    """Vectors in space; motions of the ground and platforms only where they are."""
    names = columns(["a"], dimension=3, platform=True, vertical=True, second=True)
    assert names[4:7] == (
        "base.acceleration_m_s2",
        "base.vertical_acceleration_m_s2",
        "base.second_acceleration_m_s2",
    )
    assert names[7:11] == ("a.angle_rad", "a.angle_x_rad", "a.angle_y_rad", "a.angle_z_rad")
    assert {f"a.gap_{corner}_m" for corner in (1, 2, 3, 4)} < set(names)
    assert names[27:33] == (
        "platform.drift_m",
        "platform.velocity_m_s",
        "platform.acceleration_m_s2",
        "platform.drift_second_m",
        "platform.velocity_second_m_s",
        "platform.acceleration_second_m_s2",
    )
    assert names[-2:] == ("foundation.base_shear_N", "foundation.base_shear_second_N")
    assert len(names) == 5 + 2 + 20 + 6 + 13 + 2
    assert len(columns(["a"], platform=True)) == len(columns(["a"])) + 4


@pytest.mark.parametrize(
    ("foundation", "moves"),
    [
        ("", False),
        ("kind = 'oscillator'\nmass = 1.0\nperiod = 0.5", True),
        ("kind = 'elastic'\nwidth = 2\nheight = 1\ndensity = 1\nyoung = 1\npoisson = 0", False),
    ],
)
def test_columns_of_a_scene(foundation: str, moves: bool) -> None:
    """They are those of what the scene has."""
    scene = parse_scene(
        "[[block]]\nwidth = 1\nheight = 1\nmass = 1\nmodel = 'rigid'\n"
        f"[foundation]\n{foundation}\n"
        "[motion]\nkind = 'none'\n[motion.vertical]\nkind = 'sine'\namplitude_g = 1\nperiod = 1\n"
        "[time]\nend = 1\nstep = 0.1"
    )
    assert scene_columns(scene) == columns(["block"], platform=moves, vertical=True)


def test_a_history_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    """Numbers survive the file, across several flushes and more rows than the first allocation."""
    rng = np.random.default_rng(7)
    rows = rng.standard_normal((700, 3)) * 10.0 ** rng.integers(-300, 300, (700, 3))
    rows[5, 1] = math.nan
    history = History(["time_s", "a", "b"], tmp_path / "history.csv")
    for i, row in enumerate(rows):
        history.append(row)
        if i % 300 == 0:
            history.flush()
    history.flush()
    history.flush()
    again = History.read(tmp_path / "history.csv")
    assert again.columns == history.columns
    assert len(again) == 700
    for i, name in enumerate(again.columns):
        np.testing.assert_array_equal(again[name], rows[:, i])
        np.testing.assert_array_equal(history[name], rows[:, i])


def test_a_row_of_the_wrong_length_is_refused() -> None:
    """A forgotten value is an error, not a shifted column."""
    history = History(["time_s", "a"])
    with pytest.raises(ValueError, match="got 1 values for 2 columns"):
        history.append([1.0])


def test_a_column_is_a_copy() -> None:
    """Changes that a caller makes to a column do not reach the history."""
    history = History(["time_s"])
    history.append([1.0])
    history["time_s"][0] = 2.0
    assert history["time_s"][0] == 1.0
    assert "time_s" in history
    assert "angle" not in history


def test_what_is_no_history_is_refused(tmp_path: Path) -> None:
    """A missing file and a file with words in it are bad input, in one line."""
    with pytest.raises(SceneError, match=r"history\.csv"):
        History.read(tmp_path / "history.csv")
    (tmp_path / "words.csv").write_text("time_s\nnever\n")
    with pytest.raises(SceneError, match=r"words\.csv") as raised:
        History.read(tmp_path / "words.csv")
    assert "\n" not in str(raised.value)


def test_a_line_that_was_being_written_is_left_out(tmp_path: Path) -> None:
    """A run that is killed may leave half a line."""
    (tmp_path / "history.csv").write_text("time_s,a\n0,1\n1,2\n2")
    assert History.read(tmp_path / "history.csv")["time_s"].tolist() == [0.0, 1.0]


def test_rows_of_many_blocks_are_those_that_came(tmp_path: Path) -> None:
    """One by one and many at once, in memory, in the file, and gone on with."""
    rows = np.random.default_rng(1).standard_normal((3 * BLOCK + 700, 2))
    history, first = History(["time_s", "b"], tmp_path / "history.csv"), 0
    for count in (1, BLOCK - 2, 1, 1, BLOCK + 300, len(rows)):
        history.extend(rows[first : first + count])
        first += count
        history.flush()
    again = History.resumed(history.columns, tmp_path / "history.csv", BLOCK + 10)
    for row in rows[BLOCK + 10 :]:
        again.append(row)
    again.flush()
    for table in (history, again, History.read(tmp_path / "history.csv")):
        assert len(table) == len(rows)
        assert np.array_equal(table["time_s"], rows[:, 0])
        assert np.array_equal(table["b"], rows[:, 1])


def test_without_space_for_a_second_copy_rows_stay_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    rows = np.random.default_rng(2).standard_normal((2 * BLOCK + 3, 2))
    history = History(["time_s", "b"], tmp_path / "history.csv")
    for part in (rows[:BLOCK], rows[BLOCK:]):
        history.extend(part)
        history.flush()
    assert np.array_equal(history["b"], rows[:, 1])
    assert np.array_equal(History.read(tmp_path / "history.csv")["b"], rows[:, 1])
    assert not any(isinstance(block, np.memmap) for block in history._blocks)


def test_rows_that_are_in_the_file_take_no_memory(tmp_path: Path) -> None:
    rows = np.random.default_rng(3).standard_normal((2 * BLOCK + 3, 2))
    history = History(["time_s", "b"], tmp_path / "history.csv")
    history.extend(rows)
    history.flush()
    assert [isinstance(block, np.memmap) for block in history._blocks] == [True, True, False]
    assert [file.name for file in tmp_path.iterdir()] == ["history.csv"]
    assert np.array_equal(history["b"], rows[:, 1])
