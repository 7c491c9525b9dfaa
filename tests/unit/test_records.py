"""Recorded accelerograms: formats, units, windows, baselines, and what is wrong with a file."""

from __future__ import annotations

import codecs
import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from solver.errors import SceneError
from solver.excitation.kinds import base_motion, read_record
from solver.excitation.sampled import without_baseline
from solver.scene.motion import RecordSpec

G = 9.81
VALUES = [0.01, -0.02, 0.035, 0.5, -0.125, 0.0, 0.25]

TITLE = "PEER STRONG MOTION DATA\nA QUAKE, 1/2/2003, A STATION, 90\n"
UNITS = "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=15.0 Hz\n"


def fortran(values: list[float], columns: int, form: str = "15.7E") -> str:
    """Values in reading order, as Fortran writes them."""
    words = [f"{value:{form}}" for value in values]
    lines = [words[i : i + columns] for i in range(0, len(words), columns)]
    return "".join("".join(line) + "\n" for line in lines)


def peer(counted: str, columns: int = 5, units: str = UNITS, count: int = len(VALUES)) -> str:
    return TITLE + units + counted + "\n" + fortran(VALUES[:count], columns)


def record(folder: Path, text: str | bytes, name: str = "motion.AT2", **options: Any) -> Any:
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return base_motion(RecordSpec(file=file, **options), 3.0)


def refusal(folder: Path, text: str | bytes, name: str = "motion.AT2", **options: Any) -> str:
    """The one line that a bad file gives, the folder cut off."""
    with pytest.raises(SceneError) as caught:
        record(folder, text, name, **options)
    assert caught.value.exit_code == 2
    message = str(caught.value)
    assert "\n" not in message
    return message.replace(f"{folder}/", "")


@pytest.mark.parametrize(
    "text",
    [
        peer("NPTS=      7, DT=   .0050 SEC"),
        peer("NPTS=      7, DT=   .0050 SEC,   0 POLE @    30.00000 HZ,  -5 POLE @      .15000"),
        peer("NPTS=   7, dt=  .00500"),
        peer("npts = 7 , dt = 5.0E-03SEC", columns=8),
        peer("   7    0.0050   NPTS, DT", columns=1),
        peer("NPTS=7, DT=.005", columns=8).replace("\n", "\r\n") + "\r\n\x1a",
        peer("NPTS=7, DT=.005").replace("E-", "D-"),
        peer("NPTS=7, DT=.005", units="one line more\nThe units are (g)\n"),
        peer("NPTS=7, DT=.005").replace("A QUAKE", "Un séisme"),
        peer("NPTS=7, DT=.005").lower(),
    ],
)
def test_files_of_peer(tmp_path: Path, text: str) -> None:
    motion = record(tmp_path, text)
    np.testing.assert_allclose(motion.value, G * np.array(VALUES), rtol=1e-12)
    np.testing.assert_allclose(motion.time, 0.005 * np.arange(7), atol=1e-15)
    assert motion.step == 0.005
    assert motion.peak == pytest.approx(0.5 * G)


COLUMNS = [f"{0.02 * i:.2f} {value}" for i, value in enumerate(VALUES)]


@pytest.mark.parametrize(
    ("lines", "options"),
    [
        (COLUMNS, {"units": "g"}),
        (["time (s), acceleration [G]", *(line.replace(" ", ",") for line in COLUMNS)], {}),
        (["# units: g", *(line.replace(" ", ";") for line in COLUMNS)], {"units": "g"}),
        ([f"{0.02 * i + 7:g}\t{v}" for i, v in enumerate(VALUES)], {"units": "g"}),
        ([str(value) for value in VALUES], {"units": "g", "dt": 0.02}),
        (["Acceleration in units of g", *map(str, VALUES), ""], {"dt": 0.02}),
    ],
)
def test_columns(tmp_path: Path, lines: list[str], options: dict[str, Any]) -> None:
    motion = record(tmp_path, "\n".join(lines), "motion.txt", **options)
    np.testing.assert_allclose(motion.value, G * np.array(VALUES), rtol=1e-12)
    np.testing.assert_allclose(motion.time, 0.02 * np.arange(7), atol=1e-12)


@pytest.mark.parametrize("form", [".3f", ".2f", ".6g", ".5E", "g"])
def test_times_are_as_even_as_their_digits_tell(tmp_path: Path, form: str) -> None:
    """1/30 s printed with few digits, up to times that have more digits before the point."""
    lines = "\n".join(f"{i / 30:{form}} {i % 7}" for i in range(3500))
    motion = record(tmp_path, lines, "motion.txt", units="g")
    assert motion.step == pytest.approx(1 / 30, abs=1e-5 / 3)


@pytest.mark.parametrize(
    ("header", "unit"),
    [
        ("ACCELERATION TIME SERIES IN UNITS OF CM/S**2\n", 0.01),
        ("UNITS: cm/sec/sec\n", 0.01),
        ("Acc (m/s\N{SUPERSCRIPT TWO})\n", 1.0),
        ("ACCELERATION TIME SERIES IN CM/SEC/SEC\n", 0.01),
        ("Acceleration in cm/s2\n", 0.01),
        ("acc (ms-2)\n", 1.0),
        ("Peak velocity 30 cm/s 2.3 s after the start, 5 cm/s 2 s later\nacc (g)\n", G),
        ("Sampling interval (msec): 5\nacc (gal)\n", 0.01),
        ("acc (m s\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT TWO})\n", 1.0),
        ("acc_cm/s2 [cm s^-2]\n", 0.01),
        ("Time units: s, Acceleration units: cm/s2\n", 0.01),
        ("PGV (cm/s): 20, acc (g)\n", G),
        ("acc (ft/s2)\n", 0.3048),
        ("acc (in/sec^2)\n", 0.0254),
    ],
)
def test_units_of_the_header(tmp_path: Path, header: str, unit: float) -> None:
    text = peer("NPTS=7, DT=.005", units=header)
    assert record(tmp_path, text, scale=-2.0).value == pytest.approx(-2 * unit * np.array(VALUES))


def test_units_are_those_of_scene_and_header(tmp_path: Path) -> None:
    silent = peer("NPTS=7, DT=.005", units="")
    assert record(tmp_path, silent, units="cm/s2").peak == pytest.approx(0.005)
    assert refusal(tmp_path, silent).startswith("motion.units is required (")
    clear = peer("NPTS=7, DT=.005")
    assert record(tmp_path, clear, units="g").peak == pytest.approx(0.5 * G)
    assert refusal(tmp_path, clear, units="m/s2") == (
        'motion.units: got "m/s2", allowed "g", as line 3 of motion.AT2 says'
    )
    odd = peer("NPTS=7, DT=.005", units="UNITS OF COUNTS\n")
    for options in ({}, {"units": "g", "scale": 1e-3}):
        message = refusal(tmp_path, odd, **options)
        assert message.startswith("motion.AT2: line 3: got units of counts, allowed ")
    odd = peer("NPTS=7, DT=.005", units="UNITS OF MINE\n")
    assert record(tmp_path, odd, units="g", scale=1e-3).peak == pytest.approx(5e-4 * G)
    assert refusal(tmp_path, odd).startswith("motion.AT2: line 3: got units of mine, allowed ")
    parts = peer("NPTS=7, DT=.005", units="acc (%g)\n")
    assert refusal(tmp_path, parts, units="g").startswith("motion.AT2: line 3: got units of %g, ")


def test_several_units_in_a_header(tmp_path: Path) -> None:
    """The scene says which; without a word of it none is chosen."""
    text = "units: g\ntime (s), acc (m/s2)\n" + "\n".join(COLUMNS)
    assert refusal(tmp_path, text, "motion.txt") == (
        "motion.txt: got g in line 1 and m/s2 in line 2, allowed one unit, or motion.units"
    )
    assert record(tmp_path, text, "motion.txt", units="m/s2").peak == pytest.approx(0.5)
    assert "line 1 of motion.txt says" in refusal(tmp_path, text, "motion.txt", units="cm/s2")


@pytest.mark.parametrize("heading", ["Time (ms),Acc (g)", "t [msec], a (g)", "time_ms,acc_g"])
def test_times_in_milliseconds(tmp_path: Path, heading: str) -> None:
    text = "\n".join([heading, *COLUMNS])
    message = refusal(tmp_path, text, "motion.txt")
    assert message == "motion.txt: line 1: got times in ms, allowed times in s"


@pytest.mark.parametrize("units", ["VELOCITY TIME SERIES IN UNITS OF CM/S", "UNITS OF CM"])
def test_velocities_and_displacements_are_no_accelerations(tmp_path: Path, units: str) -> None:
    text = peer("NPTS=7, DT=.005", units=f"{units}\n")
    for options in ({}, {"units": "cm/s2"}):
        message = refusal(tmp_path, text, "motion.VT2", **options)
        assert message.startswith("motion.VT2: line 3: got units of cm")
        assert message.endswith(
            ", allowed accelerations in g, m/s2, cm/s2, mm/s2, mg, g/10, ft/s2, in/s2"
        )


COUNT = "got {}, allowed NPTS= number of values, DT= time between them in s"
EXPECTED = "allowed an accelerogram: a layout of docs/motions.md, or columns of numbers"
BINARY = (
    "motion.AT2: got binary data, allowed a text, or obspy installed (pip install obspy), "
    "which reads MiniSEED, SAC and others"
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (peer("NPTS=7, DT=.005", count=6),
         "motion.AT2: line 6: got the end of the file after 6 values, "
         "allowed 7 values, as line 4 says"),
        (peer("NPTS=6, DT=.005"),
         "motion.AT2: line 6: got more values, allowed 6 values, as line 4 says"),
        (peer("NPTS=7, DT=.005")[:-3],
         'motion.AT2: line 6: got "0.0000000E+00 2.5000000E-", allowed finite numbers'),
        (peer("NPTS=7, DT=.005").replace("3.5000000E-02", "NaN"),
         'motion.AT2: line 5: got "NaN", allowed finite numbers'),
        (peer("NPTS=7, DT=.005").replace("3.5000000E-02", "********"),
         'motion.AT2: line 5: got "********", allowed finite numbers'),
        (peer("NPTS= , DT=.005"), "motion.AT2: line 4: " + COUNT.format('"NPTS= , DT=.005"')),
        (peer("NPTS=7, DT=0.0"), "motion.AT2: line 4: " + COUNT.format('"NPTS=7, DT=0.0"')),
        (peer("NPTS=7, DT=nan"), "motion.AT2: line 4: " + COUNT.format('"NPTS=7, DT=nan"')),
        (peer("NPTS=1, DT=.005"), "motion.AT2: line 4: " + COUNT.format('"NPTS=1, DT=.005"')),
        (TITLE, "motion.AT2: line 2: " + COUNT.format('"A QUAKE, 1/2/2003, A STATION, 90"')),
        (TITLE + UNITS + "NPTS=7, DT=.005\n",
         "motion.AT2: line 4: got the end of the file after 0 values, "
         "allowed 7 values, as line 4 says"),
        ("", f"motion.AT2: line 1: got an empty file, {EXPECTED}"),
        ("\n \n", f"motion.AT2: line 1: got an empty file, {EXPECTED}"),
        (b"PEER\nNPTS=7\n\x00\x01\x02", BINARY),
        (b"\x1f\x8b\x08abc", BINARY),
    ],
)  # fmt: skip
def test_bad_files_of_peer(tmp_path: Path, text: str | bytes, message: str) -> None:
    """One line that names file, line and what was expected."""
    assert refusal(tmp_path, text) == message


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("0 1\n.1 2\n.2 3\n.4 4\n", {},
         "motion.txt: line 4: got time .4, 0.2 s after the last one, allowed times equally far"),
        ("t a\n0 1\n.01 2\n.02 3\n.03 4\n.0402 4\n.05 4\n.06 4\n", {},
         "motion.txt: line 6: got time .0402, 0.0102 s after"),
        ("0 1\n.1 2\n.1 3\n.2 4\n", {}, "motion.txt: line 3: got time .1, 0 s after the last one"),
        ("0 1\n0 2\n", {}, "motion.txt: line 2: got time 0, 0 s after the last one"),
        ("1 1\n0 2\n", {}, "motion.txt: line 2: got time 0, -1 s after the last one"),
        ("0.00 1\n0.00 2\n0.01 3\n0.01 4\n", {}, "motion.txt: line 2: got time 0.00, 0 s after"),
        ("0 1\n.1 2\n.2\n", {}, "motion.txt: line 3: got a line of 1, allowed 2 as in line 1"),
        ("0,01;0,2\n0,02;0,3\n", {}, f'motion.txt: line 1: got "0,01;0,2", {EXPECTED}, decimals'),
        ("0 1\n.1 nan\n", {}, f'motion.txt: line 2: got ".1 nan", {EXPECTED}'),
        ("0 1\n.1 1_0\n", {}, f'motion.txt: line 2: got ".1 1_0", {EXPECTED}'),
        ("time, a\n", {}, f"motion.txt: line 1: got too few numbers, {EXPECTED}"),
        ("0 1\n", {}, f"motion.txt: line 1: got too few numbers, {EXPECTED}"),
        ("3.0\n", {"dt": 0.1}, f"motion.txt: line 1: got too few numbers, {EXPECTED}"),
        ("1\n2\n3\n", {}, "motion.dt is required (dt > 0, s): motion.txt does not say"),
        ("1\n2 3\n3\n", {"dt": 0.1}, "motion.txt: line 2: got a line of 2, allowed 1 as in line 1"),
        ("1 2 3\n4\n5 6 7\n", {"dt": 0.1}, "motion.txt: line 2: got a line of 1, allowed 3 as in"),
        ("t a\n0 1\n.1 2\n", {"dt": 0.2},
         "motion.dt: got 0.2, allowed 0.1, as its times of motion.txt says"),
        ("0 1\n.1 2\n", {"dt": 0.1}, "motion.txt: line 1: got 2 columns, allowed one accelerogram"),
        ("t, EW, NS\n" + "".join(f"{k / 100},{k % 3},{-k % 4}\n" for k in range(9)), {},
         "motion.txt: line 2: got 2 columns beside that of time (EW, NS), allowed one "),
        ("".join(f"{k / 100} 1 2 3\n" for k in range(9)), {"dt": 0.01},
         "motion.txt: line 1: got 3 columns beside that of time, allowed one accelerogram"),
        (peer("NPTS=7, DT=.005"), {"dt": 0.1},
         "motion.dt: got 0.1, allowed 0.005, as line 4 of motion.txt says"),
    ],
)  # fmt: skip
def test_bad_columns(tmp_path: Path, text: str, options: dict[str, Any], message: str) -> None:
    assert refusal(tmp_path, text, "motion.txt", units="g", **options).startswith(message)


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SceneError, match=r"^motion.vertical.file: got .*x.AT2 \(no such file"):
        read_record(RecordSpec(file=tmp_path / "x.AT2"), "motion.vertical")
    with pytest.raises(SceneError, match=r"^motion.file: got .* \(a folder\), allowed a file with"):
        read_record(RecordSpec(file=tmp_path))

    def forbidden(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", forbidden)
    (tmp_path / "x.AT2").touch()
    with pytest.raises(SceneError, match=r"^motion.file: got .* \(permission denied\), allowed"):
        read_record(RecordSpec(file=tmp_path / "x.AT2"))


def test_window(tmp_path: Path) -> None:
    """The samples from the first to the last time, moved to `start`."""
    text = peer("NPTS=7, DT=.005")
    motion = record(tmp_path, text, window=(0.0099, 0.0251), start=1.0)
    np.testing.assert_allclose(motion.value, G * np.array(VALUES[2:6]))
    np.testing.assert_allclose(motion.time, 1 + 0.005 * np.arange(4))
    assert (motion.acceleration(0.9999), motion.acceleration(1.0)) == (0.0, 0.035 * G)
    assert len(record(tmp_path, text, window=(0.0, 0.03)).value) == 7
    assert refusal(tmp_path, text, window=(0.01, 0.04)) == (
        "motion.window: got [0.01, 0.04], allowed times up to 0.03 s, the length of motion.AT2"
    )
    assert refusal(tmp_path, text, window=(0.011, 0.016)).endswith(
        "allowed two samples or more, which are 0.005 s apart"
    )
    with pytest.raises(SceneError, match=r"^window: got \[2.0, 1.0\], allowed a first time before"):
        RecordSpec(file=tmp_path / "motion.AT2", window=(2.0, 1.0))


@pytest.mark.parametrize(("baseline", "degree"), [("constant", 0), ("linear", 1), ("quadratic", 2)])
def test_baseline(tmp_path: Path, baseline: Any, degree: int) -> None:
    """A polynomial disappears; of the rest the squared velocities are the least there are."""
    time = np.linspace(0, 1, 401)
    drift = sum((k + 1) * time**k for k in range(degree + 1))
    wave = np.sin(40 * time) * np.exp(-3 * time)

    def read(values: np.ndarray, **options: Any) -> Any:
        text = "".join(f"{value:.17g}\n" for value in values)
        return record(tmp_path, text, "motion.txt", units="m/s2", dt=0.0025, **options)

    assert read(drift, baseline=baseline).peak < 1e-12
    cleaned = read(wave, baseline=baseline)
    np.testing.assert_allclose(
        read(wave + drift, baseline=baseline).value, cleaned.value, atol=1e-12
    )

    def squared(values: np.ndarray) -> float:
        speed = read(values).velocity(time)
        return float(speed @ speed)

    least = squared(cleaned.value)
    assert least < squared(wave)
    for k in range(degree + 1):
        for change in (-1e-3, 1e-3):
            assert squared(cleaned.value + change * time**k) > least
    assert read(wave, baseline="none").value == pytest.approx(wave, abs=1e-15)
    assert read(wave[:2], baseline=baseline).velocity(1.0) == pytest.approx(0, abs=1e-15)


def test_the_integral_is_that_of_the_broken_line(tmp_path: Path) -> None:
    motion = record(tmp_path, peer("NPTS=7, DT=.005"), start=0.1)
    fine = np.linspace(0.09, 0.14, 100001)
    slow = np.array([motion.acceleration(float(t)) for t in fine])
    np.testing.assert_allclose(motion.acceleration(fine), slow, atol=1e-14)
    gained = np.concatenate(([0.0], np.cumsum((slow[1:] + slow[:-1]) / 2 * np.diff(fine))))
    speeds = motion.velocity(fine)
    np.testing.assert_allclose(speeds, gained, atol=1e-6)
    slowly = np.array([motion.velocity(float(t)) for t in fine[::100]])
    np.testing.assert_allclose(speeds[::100], slowly, atol=1e-15)
    assert motion.velocity(9.0) == pytest.approx(np.trapezoid(motion.value, motion.time), rel=1e-14)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all examples: each writes over the one before."""
    return tmp_path_factory.mktemp("records")


@given(some.data(), some.sampled_from(["NaN", "inf", "*******", "1_0", "0.1.2", "1E", "-", "x"]))
def test_a_damaged_line_is_refused_by_its_number(
    folder: Path, data: some.DataObject, word: str
) -> None:
    """A word that is no number in place of one, in any line of any file."""
    lines = peer("NPTS=7, DT=.005", columns=data.draw(some.integers(1, 8))).splitlines()
    line = data.draw(some.integers(4, len(lines) - 1))
    words = lines[line].split()
    words[data.draw(some.integers(0, len(words) - 1))] = word
    lines[line] = " ".join(words)
    assert refusal(folder, "\n".join(lines)).startswith(f"motion.AT2: line {line + 1}: got ")


@given(some.binary(max_size=200) | some.text("0123456789.,;-+eEdDg \t\n#", max_size=200))
def test_whatever_a_file_holds_is_read_or_refused_in_one_line(folder: Path, text: Any) -> None:
    for name, options in (("motion.AT2", {}), ("motion.txt", {"units": "g"})):
        try:
            motion = record(folder, text, name, **options)
        except SceneError as error:
            assert error.exit_code == 2 and "\n" not in str(error)
            assert name in str(error)
        else:
            assert np.isfinite(motion.value).all() and len(motion.value) >= 2
            assert motion.step > 0


RECORDS = Path(__file__).parents[3] / "shared" / "records"
real = pytest.mark.skipif(not RECORDS.is_dir(), reason="no recorded accelerograms here")


@real
def test_real_files() -> None:
    """All of them parse, and have the length and the peak that their index says."""
    with (RECORDS / "index.csv").open() as index:
        rows = list(csv.DictReader(index))
    assert len(rows) == 69
    for row in rows:
        units = None if row["file"].lower().endswith("at2") else "g"
        motion = read_record(RecordSpec(file=RECORDS / row["file"], units=units))
        assert motion.peak / G == pytest.approx(float(row["pga_g"]), rel=1e-3), row["file"]
        assert len(motion.value) == int(row["npts"]), row["file"]
        assert motion.step == pytest.approx(float(row["dt_s"]), rel=1e-9), row["file"]


@pytest.mark.parametrize("missing", [1, 2, 50, 98])
@pytest.mark.parametrize("count", [7, 100, 3000])
def test_a_row_that_is_missing_is_named(tmp_path: Path, missing: int, count: int) -> None:
    """The second one, too, whose interval is the first."""
    at = min(missing, count - 2)
    rows = [f"{0.005 * i:.3f} {math.sin(i):.4f}" for i in range(count) if i != at]
    message = refusal(tmp_path, "\n".join(rows), "motion.txt", units="g")
    assert message == (
        f"motion.txt: line {at + 1}: got time {0.005 * (at + 1):.3f}, 0.01 s after the last one, "
        "allowed times equally far apart, 0.005 s like most of them"
    )


class TestSpikes:
    """Samples that have lost their decimal point."""

    PEER = TITLE + UNITS + "NPTS=7, DT=.005\n" + " .0100 -.0200 .1350\n .2186 .1250 .0000 .0250\n"

    @pytest.mark.parametrize("lost", ["2186", "21.86", "-2186"])
    def test_they_are_refused_by_line_unless_trusted(self, tmp_path: Path, lost: str) -> None:
        assert record(tmp_path, self.PEER).peak == pytest.approx(0.2186 * G)
        spoilt = self.PEER.replace(".2186", lost)
        message = refusal(tmp_path, spoilt)
        assert message == (
            f"motion.AT2: line 6: got {lost} between samples of at most 0.135, "
            "allowed at most 20 times those beside it, or motion.trust = true"
        )
        peak = abs(float(lost)) * G
        assert record(tmp_path, spoilt, trust=True).peak == pytest.approx(peak)

    def test_in_two_columns_and_in_one(self, tmp_path: Path) -> None:
        values = ["0.1", "0.2", "300", "0.2", "0.1"]
        lines = [f"{0.01 * i:.2f} {value}" for i, value in enumerate(values)]
        text = "# a record\n" + "\n".join(lines)
        assert "line 4: got 300" in refusal(tmp_path, text, "m.txt", units="g")
        text = "\n".join(values)
        assert "line 3: got 300" in refusal(tmp_path, text, "m.txt", units="g", dt=0.01)

    def test_only_what_is_used_counts(self, tmp_path: Path) -> None:
        text = "0.1\n300\n0.1\n0.2\n0.1"
        options = {"units": "g", "dt": 0.01, "window": (0.02, 0.04)}
        assert record(tmp_path, text, "m.txt", **options).peak == pytest.approx(0.2 * G)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-8-sig", "latin-1"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    """UTF-16 is what some shells write into files; a superscript is no letter of ASCII."""
    text = "t (s), a (m/s\N{SUPERSCRIPT TWO})\n" + "\n".join(COLUMNS)
    mark = codecs.BOM_UTF16_BE if encoding == "utf-16-be" else b""
    (tmp_path / "m.txt").write_bytes(mark + text.encode(encoding))
    motion = read_record(RecordSpec(file=tmp_path / "m.txt"))
    assert motion.value == pytest.approx(VALUES)


def test_a_parabola_does_not_take_a_cubic_away_whole() -> None:
    """Of t^3 over a unit time a velocity t^4/4 - c1 t - c2 t^2 - c3 t^3 of least square remains.

    Its normal equations are sums c_j/(i + j + 1) = 1/(4 (i + 5)), i = 1, 2, 3.
    """
    time = np.linspace(0.0, 1.0, 4001)
    power = np.arange(1, 4)
    normal = 1 / (power[:, None] + power + 1.0)
    c = np.linalg.solve(normal, 1 / (4 * (power + 5.0)))
    remains = time**3 - (c[0] + 2 * c[1] * time + 3 * c[2] * time**2)
    assert np.abs(remains).max() > 0.03
    np.testing.assert_allclose(without_baseline(time**3, "quadratic"), remains, atol=1e-4)
    assert np.abs(without_baseline(time**2, "quadratic")).max() < 1e-9
