"""Ground motions: formulas, tables, and what is wrong with a table."""

import math

import numpy as np
import pytest

from solver.errors import SceneError
from solver.excitation.kinds import base_motion
from solver.scene.motion import SineSpec, TableSpec


def table(folder, text, **options):
    file = folder / "motion.csv"
    file.write_text(text)
    return base_motion(TableSpec(file=file, **options), 3.0)


def test_units_of_a_table_are_those_of_its_header(tmp_path):
    """Without a word in either place they are g."""
    text = "0,0\n0.1,2.0\n0.2,0\n"
    header = "time (s),acc (m/s2)\n"
    assert table(tmp_path, text).peak == pytest.approx(2 * 9.81)
    assert table(tmp_path, header + text).peak == pytest.approx(2.0)
    assert table(tmp_path, header + text, units="m/s2").peak == pytest.approx(2.0)
    assert table(tmp_path, text, units="cm/s2").peak == pytest.approx(0.02)
    with pytest.raises(SceneError, match=r'^motion.units: got "g", allowed "m/s2", as line 1 of'):
        table(tmp_path, header + text, units="g")
    with pytest.raises(SceneError, match=r"line 1: got units of cm/s, allowed accelerations in g"):
        table(tmp_path, "# units: cm/s\n" + text)


def test_sine():
    motion = base_motion(SineSpec(amplitude_g=0.4, period=0.6, cycles=1.5, start=0.1), 3.0)
    assert motion.peak == pytest.approx(3.924)
    assert motion.acceleration(0.099) == 0.0
    assert motion.acceleration(0.25) == pytest.approx(3.924)
    assert motion.acceleration(0.55) == pytest.approx(-3.924)
    assert motion.acceleration(0.15) == pytest.approx(3.924 * math.sin(math.pi / 6))
    assert motion.acceleration(1.001) == 0.0


def test_sine_without_cycles_lasts_to_the_end():
    motion = base_motion(SineSpec(amplitude_g=0.1, period=0.4), 0.3)
    last = 3 * 0.1  # 0.30000000000000004
    assert last > 0.3
    assert motion.acceleration(last) == pytest.approx(-0.981)
    assert motion.acceleration(0.31) == 0.0


def test_sine_shorter_than_a_quarter_has_a_smaller_peak():
    motion = base_motion(SineSpec(amplitude_g=-1.0, period=1.2, cycles=1 / 12), 3.0)
    assert motion.peak == pytest.approx(9.81 * 0.5)


@pytest.mark.parametrize(
    "text",
    [
        "0,0\n0.1,0.5\n0.3,-1\n",
        "# made by hand\n# 1, 2\n0 0\n0.1\t0.5\n0.3   -1\n# the end\n",
        "Zeit;Wert\r\n0;0\r\n0.1;0.5\r\n0.3;-1e0\r\n",
        "\ufeff0,0\n0.1,0.5\n0.3,-1",
    ],
)
def test_table_is_linear_between_its_rows_and_zero_outside(tmp_path, text):
    motion = table(tmp_path, text)
    times = [-0.1, 0.0, 0.05, 0.1, 0.2, 0.3, 0.301]
    expected = 9.81 * np.array([0.0, 0.0, 0.25, 0.5, -0.25, -1.0, 0.0])
    np.testing.assert_allclose([motion.acceleration(time) for time in times], expected, atol=1e-14)
    assert motion.peak == pytest.approx(9.81)


@pytest.mark.parametrize(
    ("text", "line", "got"),
    [
        ("0 0\n0.1 x\n", 2, '"0.1 x"'),
        ("t a\n0 0\n0.1 1 2\n", 3, "a line of 3"),
        ("0 0\ninf 1\n", 2, '"inf 1"'),
        ("nan 0\n1 1\n", 1, '"nan 0"'),
        ("0 0\n0.2 1\n\n0.2 1\n", 4, "time 0.2"),
        ("0 0\n0.2 1\n0.1 1\n", 3, "time 0.1"),
    ],
)
def test_table_errors_name_file_line_and_what_is_expected(tmp_path, text, line, got):
    with pytest.raises(SceneError) as caught:
        table(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'motion.csv'}: line {line}: got {got}, allowed ")
    assert "\n" not in message
