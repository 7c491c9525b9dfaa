"""Layouts of recorded motions: a made-up record of each, and headers that are damaged or talk.

A value is right or refused, never another one.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from rockslip import parse_scene, simulate
from solver.errors import SceneError
from solver.excitation.kinds import read_record, read_table
from solver.excitation.layouts.table import LAYOUTS
from solver.run.describe import describe_motion
from solver.scene.motion import Format, RecordSpec, TableSpec

G = 9.81
COUNT = 40
STEP = 0.01
WAVES = [
    [round(math.sin(0.3 * i + k) * (1 + 0.1 * i) * 5 + 0.3 * k, 3) for i in range(COUNT)]
    for k in range(3)
]
"""Three components."""


def fixed(values: list[float], columns: int, form: str) -> str:
    """Values in reading order, as Fortran writes them."""
    words = [f"{value:{form}}" for value in values]
    return "\n".join("".join(words[i : i + columns]) for i in range(0, len(words), columns))


def rows(*columns: list[float], form: str = "10.3f") -> str:
    return "\n".join(
        "".join(f"{value:{form}}" for value in row) for row in zip(*columns, strict=True)
    )


def peer() -> str:
    return (
        "MADE UP\nNOWHERE, 90\nACCELERATION TIME SERIES IN UNITS OF G\n"
        f"NPTS=  {COUNT}, DT=  .0100 SEC\n" + fixed(WAVES[0], 5, "15.7E")
    )


COUNTS = [round(200 * value) - 1500 for value in WAVES[0]]


def knet() -> str:
    lines = [
        "Origin Time       2000/01/01 00:00:00", "Lat.              41.0",
        "Long.             142.5", "Depth. (km)       30", "Mag.              6.2",
        "Station Code      XXX000", "Station Lat.      41.0", "Station Long.     141.0",
        "Station Height(m) 10", "Record Time       2000/01/01 00:00:15",
        "Sampling Freq(Hz) 100Hz", f"Duration Time(s)  {COUNT / 100:g}",
        "Dir.              N-S", "Scale Factor      3920(gal)/6182761",
        "Max. Acc. (gal)   2.806", "Last Correction   2000/01/01 00:00:15",
        "Memo.             ",
    ]  # fmt: skip
    return "\n".join(lines) + "\n" + fixed(COUNTS, 8, "9d")


def esm() -> str:
    return (
        "EVENT_NAME: MADE_UP\nEVENT_ID: X\nMAGNITUDE_W: 6.0\nNETWORK: XX\nSTATION_NAME: a, b: c\n"
        f"SAMPLING_INTERVAL_S: {STEP:.6f}\nNDATA: {COUNT}\nDURATION_S: {COUNT * STEP:.3f}\n"
        "STREAM: HNE\nUNITS: cm/s^2\nFULL_SCALE_G: 2\nPGA_CM/S^2: 19.9\nHEADER_FORMAT: DYNA 1.2\n"
        "DATA_TYPE: ACCELERATION\nUSER1: a -b 0.1\nUSER5:\n" + "\n".join(map(str, WAVES[0]))
    )


def afad() -> str:
    most = [max(map(abs, wave)) for wave in WAVES]
    return (
        "STRONG GROUND MOTION RECORDS OF TURKIYE\nPLACE                   : NOWHERE\n"
        "EARTHQUAKE MAGNITUDE    : 6.5 Mw\nSTATION ALTITUDE (m)    : 735\n"
        f"NUMBER OF DATA          : {COUNT}\nSAMPLING INTERVAL (sec) : {STEP}\n"
        f"RAW PGA VALUES (gal)    : (N-S) {most[0]} (E-W) {most[1]} (U-D) {most[2]}\n"
        "Copyright\n       N-S          E-W          U-D\n" + rows(*WAVES, form="13.6f")
    )


def asa() -> str:
    keys = {
        "VERSION DEL FORMATO": "2.0",
        "NUMERO DE CANALES": "3",
        "ORIENTACION C1-C6 (rumbo;orientacion)": "/V/N00E/N90E",
        "ORIENTACION C7-C12 (rumbo;orientacion)": "",
        "VEL. DE MUESTREO, C1-C6 (muestras/s)": "/100/100/100",
        "ESC. COMPLETA DE SENSORES, C1-C6, (g)": "/4/4/4",
        "INTERVALO DE MUESTREO, C1-C6 (s)": "/0.01/0.01/0.01",
        "UMBRAL DE DISPARO, C1-C6 (Gal)": "/4/4/4",
        "NUM. TOTAL DE MUESTRAS, C1-C6": f"/{COUNT}/{COUNT}/{COUNT}",
        "ACEL. MAX.(Gal), C1-C6": "/1/2/3",
        "UNIDADES DE LOS DATOS": "Gal (cm/s/s)",
        "FACTOR DE DECIMACION": "1",
        "FORMATO DATOS (FORTRAN,10 campos/dato)": "3F10.3",
    }
    rule = "---------+---------+---------+\n"
    return (
        "*****\n        INSTITUTO\n*****\nARCHIVO ESTANDAR DE ACELERACION:\n"
        + "".join(f"{key:39}: {value}\n" for key, value in keys.items())
        + f"=====\nDATOS DE ACELERACION:\n{rule}   CANAL-1   CANAL-2   CANAL-3\n"
        + f"         V      N00E      N90E\n{rule}" + rows(*WAVES)
    )  # fmt: skip


def cosmos(units: str = "cm/sec2(04)") -> str:
    reals = [-999.0] * 100
    reals[33], reals[34], reals[61], reals[62] = 0.005, 0.8, 10.0, COUNT * STEP

    def channel(k: int, quantity: str = "acceleration") -> str:
        return (
            f"Corrected {quantity}    (Format v01.20 with 13 text lines)\nNowhere\n"
            "Recorder: SSA-2  s/n 1238 ( 1 Chns of 12  at Sta) Sensor:FBA-11  s/n 1889\n"
            f"Sta Chan   {k}: {90 * k} deg (Rcrdr Chan  1) Location:\n"
            "Raw record length = 70.000  sec, Uncor max =   -.167 g  at   27.850 sec\n"
            "Values used when parameter or data value is unknown/unspecified:   -999, -999.0\n"
            " 100 Integer-header values follow on  10 lines, Format= (10I8)\n"
            f"{fixed([-999] * 100, 10, '8d')}\n"
            f" 100 Real-header values follow on  20 lines, Format= (5F15.6)\n"
            f'{fixed(reals, 5, "15.6f")}\n  1 Comment line(s) follow, each starting with a "|":\n'
            f"| made up\n   {COUNT}  {quantity} pts, approx    0 secs, units={units},"
            f"Format=(8F10.3)\n{fixed(WAVES[k], 8, '10.3f')}\nEnd-of-data for Chan {k} {quantity}\n"
        )

    return channel(0) + channel(2, "velocity") + channel(1)


def csmip_v2() -> str:
    def channel(k: int) -> str:
        return (
            f"Corrected accelerogram   X    Chan  {k + 1}: {90 * k} Deg     from   \n"
            "Uncorrected Accelerogram Data             Processed: 02/13/12, CGS\n"
            "Instr Period =  .0109 sec,  Damping =  .670,  Sensitivity =  .63  v/g\n"
            "                                     Uncor Max  =   .079 g , at  30.590 sec.\n"
            "At equally-spaced intervals of    .010  sec.\n"
            "Peak acceleration =    77.280    cm/sec/sec  at   30.585   sec.\n"
            f"X      Nowhere    Chan  {k + 1}: {90 * k} Deg                      \n"
            "    1  100    1    3\n  .0108814-999.00000\n"
            f"  {COUNT} points of accel data equally spaced at  .010 sec, in cm/sec2. (8f10.3)\n"
            f"{fixed(WAVES[k], 8, '10.3f')}\n"
            f"  {COUNT} points of veloc data equally spaced at  .010 sec, in cm/sec.  (8f10.3)\n"
            f"{fixed(WAVES[2], 8, '10.3f')}\n"
            f"/&  ---------- End of data for channel  {k + 1} ----------\n"
        )

    return channel(0) + channel(1)


def csmip_v1() -> str:
    return (
        "Uncorrected Accelerogram Data             Processed: 08/29/18, CGS\n"
        "Chan  1: 360 Deg                     \n"
        f"No. of Points =  {COUNT}  Record Length = 0.400 sec   at 100 Samples/sec\n"
        "Units of uncor data are sec and g.         Max  =  -.105 g, at   31.575 sec.\n"
        "    1  100    1\n  .0110742  .6700000\n"
        f" {COUNT} Accelerogram points at 100 pts/sec in units of g.       Format: (8f9.3)\n"
        + fixed(WAVES[0], 8, "9.3f")
    )


def usc() -> str:
    pairs = [number for i, value in enumerate(WAVES[0]) for number in (STEP * i, value)]
    return (
        "FILE     0 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:\nNOWHERE   21\n"
        "COMP S05W                           9\n"
        "INSTR PERIOD =  .037 SEC  DAMPING =   .568  SENSITIVITY =   1.69CM/G    69\n"
        f"NO. OF POINTS =   {COUNT}      DURATION =    .390 SEC          50\n"
        "UNITS ARE SEC AND G/10             22\nRMS ACCLN. OF COMPLETE RECORD =     .211 G/10\n"
        + fixed([0] * 100, 16, "5d") + "\n" + fixed([0.0] * 50, 8, "10.3f") + "\n"
        + fixed(pairs, 10, "7.3f")
    )  # fmt: skip


def geonet(volume: int = 1) -> str:
    def component(k: int) -> str:
        head = [[0.0] * 10 for _ in range(10)]
        head[3][0 if volume == 1 else 3] = COUNT
        head[6][4] = STEP if volume == 1 else STEP / 2
        head[6][5] = STEP
        head[4][0], head[3][9], head[6][9] = 200.0, 26000, 9806.6
        more = ""
        if volume == 2:
            head[3][0], head[3][4], head[3][5] = 2 * COUNT, COUNT, COUNT
            more = 2 * ("\n" + fixed(WAVES[2], 10, "8.3f"))
        raw = "Raw readings in units of 1.00 mm/s/s  at intervals of 0.010 s"
        corrected = "Instrument corrected data at 0.010 sec intervals"
        return (
            f"{'Uncorrected' if volume == 1 else 'Corrected'} accelerogram X GNS Science\nSite X\n"
            f"Number of points  {COUNT}    Duration 0.4 s\n{raw if volume == 1 else corrected}\n"
            f"Component N{k}0W\nAcceleration:  Peak    -22.0 mm/s/s at  51.15 s\n"
            f"Velocity record unevaluated\n{rows(*zip(*head, strict=True), form='8.2f')}\n"
            f"{fixed(WAVES[k], 10, '8.3f')}{more}\n"
        )

    return component(0) + component(1)


MADE: dict[str, tuple[str, str, str | None, float]] = {
    "peer": (peer(), "m.txt", None, G),
    "knet": (knet(), "m.NS", "N-S", 0.01),
    "esm": (esm(), "m.ASC", "HNE", 0.01),
    "afad": (afad(), "m.txt", "N-S", 0.01),
    "asa": (asa(), "m.191", "V", 0.01),
    "cosmos": (cosmos(), "m.V2c", "0: 0 deg", 0.01),
    "csmip V2": (csmip_v2(), "m.V2", "0 Deg", 0.01),
    "csmip V1": (csmip_v1(), "m.V1", "360 Deg", G),
    "usc": (usc(), "m.e0a", "S05W", 0.1 * G),
    "geonet V1A": (geonet(), "m.V1A", "N00W", 0.001),
    "geonet V2A": (geonet(2), "m.V2A", "N00W", 0.001),
}
"""For each layout a file, its name, the name of its first component, and its unit in m/s^2."""


def expected(layout: str) -> np.ndarray:
    """The samples of the first component, m/s^2."""
    if layout == "knet":
        counts = np.array(COUNTS)
        return 0.01 * (counts - counts.mean()) * 3920 / 6182761
    return np.array(WAVES[0]) * MADE[layout][3]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("layouts")


def record(folder: Path, text: str, name: str = "m.txt", **options: Any) -> Any:
    (folder / name).write_text(text)
    return read_record(RecordSpec(file=folder / name, trust=True, **options))


def refusal(folder: Path, text: str, name: str = "m.txt", **options: Any) -> str:
    with pytest.raises(SceneError) as caught:
        record(folder, text, name, **options)
    return str(caught.value).replace(f"{folder}/", "")


def test_every_layout_has_a_record() -> None:
    assert {name.split()[0] for name in MADE} | {"columns"} == set(LAYOUTS)


@pytest.mark.parametrize("layout", MADE)
def test_a_record_of_each(folder: Path, layout: str) -> None:
    """Recognised by its signature and by its name; samples, interval and component are right."""
    text, name, component, _ = MADE[layout]
    for form in (None, layout.split()[0]):
        motion = record(folder, text, name, format=form, column=component)
        np.testing.assert_allclose(motion.value, expected(layout), rtol=1e-12, atol=1e-12)
        assert motion.step == pytest.approx(STEP, rel=1e-6)
    lines = dict(describe_motion(motion, None)[1])
    title = LAYOUTS[layout.split()[0]].TITLE
    assert lines["read as"].startswith(f"{title}: {COUNT} samples, 0.01 s apart (")
    assert component is None or f"component {component}" in lines["read as"]


@pytest.mark.parametrize(
    ("layout", "second"),
    [("afad", "E-W"), ("asa", "N00E"), ("cosmos", "1: 90 deg"), ("csmip V2", "90 Deg"),
     ("geonet V1A", "N10W"), ("geonet V2A", "N10W")],
)  # fmt: skip
def test_one_of_several_components(folder: Path, layout: str, second: str) -> None:
    """By number or name, never all of them one after another."""
    text, name, _, unit = MADE[layout]
    for column in (2, second, second.lower()):
        motion = record(folder, text, name, column=column)
        np.testing.assert_allclose(motion.value, np.array(WAVES[1]) * unit, rtol=1e-12)
    assert "motion.column, 1 to" in refusal(folder, text, name)
    assert refusal(folder, text, name, column="Z9").startswith('motion.column: got "Z9", allowed 1')


@pytest.mark.parametrize("layout", MADE)
def test_what_the_scene_says_otherwise(folder: Path, layout: str) -> None:
    """Another unit, interval or layout than that of the header is refused with both."""
    text, name, component, unit = MADE[layout]
    units = {G: "g", 0.01: "cm/s2", 0.1 * G: "g/10", 0.001: "mm/s2"}[unit]
    assert record(folder, text, name, column=component, units=units, dt=STEP).step == pytest.approx(
        STEP
    )
    other = "m/s2"
    message = refusal(folder, text, name, column=component, units=other)
    assert message.startswith(f'motion.units: got "{other}", allowed "{units}", as line ')
    message = refusal(folder, text, name, column=component, dt=0.02)
    assert message.startswith("motion.dt: got 0.02, allowed 0.01, as ")
    form = "esm" if layout != "esm" else "knet"
    message = refusal(folder, text, name, column=component, format=form)
    assert message == f'motion.format: got "{form}", allowed "{layout.split()[0]}", which {name} is'


@pytest.mark.parametrize("layout", MADE)
@given(data=some.data())
def test_damaged_headers(folder: Path, layout: str, data: some.DataObject) -> None:
    """A line that is missing, doubled or (of words) cut off: right or refused."""
    text, name, component, _ = MADE[layout]
    lines = text.splitlines()
    at = data.draw(some.integers(0, len(lines) - 1))
    cut = data.draw(some.integers(0, len(lines[at])))
    worded = any(sign.isalpha() for sign in lines[at].replace("E+", "").replace("E-", ""))
    kinds = ["missing", "doubled", *(["cut"] if worded else [])]
    damage = data.draw(some.sampled_from(kinds))
    spoilt = {"missing": [], "doubled": 2 * [lines[at]], "cut": [lines[at][:cut]]}[damage]
    lines[at : at + 1] = spoilt
    try:
        motion = record(folder, "\n".join(lines), name, column=component)
    except SceneError as error:
        assert "\n" not in str(error)
    else:
        assert motion.step == pytest.approx(STEP, rel=1e-6)
        np.testing.assert_allclose(motion.value, expected(layout), rtol=1e-12, atol=1e-12)


TALK = [
    "1 g = 981 cm/s2",
    "with 1 g = 9.81 m/s2",
    "PGA 294 cm/s/s",
    "PGA (gal): 294",
    "Peak acceleration = 77.3 cm/sec/sec at 3.2 sec",
    "Max. Acc. (gal)   29.070",
    "Acceleration (gal)   29.070",
    "accelerogram of a sensor of 981 cm/s2 per g",
    "Trigger level (gal): 4",
    "trigger threshold 0.01 g",
    "full scale of the sensor (g): 2",
    "Sensor range (m/s2) 20",
    "FULL_SCALE_G: 4",
    "Sensitivity = .63 v/g",
    "RMS 1.17 mm/s/s",
    "Peak velocity 30 cm/s, displacement 5 cm",
    "noise level in cm/s2: 0.1",
    "Station height (m) 10",
    "Hypocentre depth 12 km",
    "instrument period 0.05 s, sensor of 100 Hz",
    "Distance to the rupture (cm): 3e6",
]
"""Quantities, none of which is the unit of the samples."""

STATED = [
    "units: {}", "Units of {}", "unit of acceleration: {}", "accelerations (in {})",
    "acceleration ({})", "acceleration time history in {}",
    "ACCELERATION TIME SERIES IN UNITS OF {}", "a [{}]", "#AmplitudeUnit:  {}. corrected",
]  # fmt: skip
NAMES = {
    "g": G, "G": G, "m/s2": 1.0, "m/s^2": 1.0, "cm/s2": 0.01, "gal": 0.01, "CM/SEC/SEC": 0.01,
    "mm/s/s": 1e-3, "mg": 1e-3 * G, "G/10": 0.1 * G,
}  # fmt: skip


@given(
    some.lists(some.sampled_from(TALK), max_size=4),
    some.sampled_from(STATED),
    some.sampled_from(sorted(NAMES)),
    some.data(),
)
def test_headers_that_talk(
    folder: Path, talk: list[str], stated: str, name: str, data: some.DataObject
) -> None:
    """The stated unit is used, not quantities beside it; a key with the same unit agrees."""
    header = [line for line in talk if not line.startswith("1")]
    body = "\n".join(f"{value}" for value in WAVES[0])
    said = stated.format(name)
    at = data.draw(some.integers(0, len(header)))
    text = "\n".join([*header[:at], said, *header[at:], body])
    motion = record(folder, text, dt=STEP)
    np.testing.assert_allclose(motion.value, np.array(WAVES[0]) * NAMES[name], rtol=1e-12)
    silent = "\n".join([*header, body])
    assert refusal(folder, silent, dt=STEP).startswith("motion.units is required")
    motion = record(folder, silent, dt=STEP, units="g")
    np.testing.assert_allclose(motion.value, np.array(WAVES[0]) * G, rtol=1e-12)


@pytest.mark.parametrize("header", ["Accelerations, cm/s/s", "(cm/s^2)", "values gal", "milli-g"])
def test_a_hint_of_another_unit(folder: Path, header: str) -> None:
    """Too little for a unit, enough against another one."""
    text = "\n".join([header, *map(str, WAVES[0])])
    assert "motion.units is required" in refusal(folder, text, dt=STEP)
    assert 'motion.units: got "g", allowed "' in refusal(folder, text, dt=STEP, units="g")


@pytest.mark.parametrize(
    ("header", "step"),
    [
        ("NPTS: 40\nDT: 0.01", 0.01),
        ("40 points at equal spacing of 0.02 sec\nthe points follow", 0.02),
        ("Number of points = 40, sampling interval (ms): 5", 0.005),
        ("#SampleRate(Hz): 200", 0.005),
        ("sampling frequency 100 Hz", 0.01),
        ("time step 0.01 s", 0.01),
        ("recorded at 50 samples/sec", 0.02),
        ("No. of data points: 40\nat intervals of 0.01 s", 0.01),
    ],
)
def test_numbers_and_intervals_in_words(folder: Path, header: str, step: float) -> None:
    text = "\n".join([header, "units: g", *map(str, WAVES[0])])
    assert record(folder, text).step == pytest.approx(step)
    message = refusal(folder, text, dt=0.04)
    assert message.startswith(f"motion.dt: got 0.04, allowed {step:g}, as line ")
    if "40" in header:
        message = refusal(folder, text + "\n0.1")
        assert message.startswith("m.txt: got 40 samples in line ")
    timed = [f"{i * 0.04:.2f} {value}" for i, value in enumerate(WAVES[0])]
    message = refusal(folder, "\n".join([header, "units: g", *timed]))
    assert f"got {step:g} s between samples, allowed 0.04 s as in its times" in message


TIMES = [STEP * i for i in range(COUNT)]
MANY = "t (s), x (g), y (g), z (g)\n" + rows(TIMES, *WAVES, form="12.3f")
OWN_UNITS = "t (s)  acc (g)  vel (cm/s)  acc_gal  note\n" + rows(
    TIMES, *WAVES, WAVES[0], form="12.3f"
)
HEADED = "   N-S   E-W   U-D\n" + rows(*WAVES)
PLAIN = "\n".join(map(str, WAVES[0]))
QUOTED = "\n".join(f'"{STEP * i:.2f}","{v}"' for i, v in enumerate(WAVES[0]))
UNQUOTED = QUOTED.replace('"', "")
NUMBERED = "no, value (g)\n" + "\n".join(f"{i},{v}" for i, v in enumerate(WAVES[0], start=1))
GAL: dict[str, Any] = {"dt": STEP, "units": "cm/s2"}
TENTHS = "UNITS ARE SECONDS AND G/10\n" + PLAIN
OLD = (
    "ACCELERATION TIME HISTORY (G'S): NIT = 2\n  16384 DT = .0050 SEC\nNPTS= 3, DT= 1\n"
    f"NPTS=  {COUNT}, DT= .01000 SEC, SCALED FACTOR = 1.0\n"
)
IN_G = afad().partition("U-D\n")[0] + "U-D\n" + rows(
    *[[value / 981 for value in wave] for wave in WAVES], form="13.6f"
)  # fmt: skip
UNEVEN = usc().replace("   .010", "   .012").replace("  0.010", "  0.012")

RULES: list[tuple[str, dict[str, Any], str | tuple[int, float]]] = [
    # columns: components side by side, with times, with headings of their own
    (HEADED, GAL, "m.txt: line 2: got 3 columns (N-S, E-W, U-D), allowed one accelerogram: "
                  "motion.column, 1 to 3 or a name"),
    (HEADED, GAL | {"column": 3}, (2, 0.01)),
    (HEADED, GAL | {"column": "U-D"}, (2, 0.01)),
    (rows(*WAVES), GAL, "got 3 columns, allowed"),
    (fixed(WAVES[0], 8, "10.3f"), GAL, "; values in reading order go one to a line"),
    (MANY, {}, "motion.column, 2 to 4 or a name"),
    (MANY, {"column": 3}, (1, G)),
    (MANY, {"column": "y"}, (1, G)),
    (MANY, {"column": 1}, "motion.column: got 1, allowed 2, 3, 4 or"),
    (OWN_UNITS, {"column": 2}, (0, G)),
    (OWN_UNITS, {"column": "acc_gal"}, (2, 0.01)),
    (OWN_UNITS, {"column": "vel"}, "got units of cm/s, allowed accelerations"),
    (OWN_UNITS, {"column": 5}, "motion.units is required"),
    ("recording unit: K2\n" + OWN_UNITS, {"column": 2}, (0, G)),
    # row numbers, quotes, decimal commas
    (NUMBERED, {}, "got row numbers in the first column"),
    (NUMBERED.replace("no, ", ""), {}, "got row numbers in the first column"),
    (NUMBERED, {"column": 2, "dt": STEP}, (0, G)),
    ('"t","acc (g)"\n' + QUOTED, {}, (0, G)),
    *((UNQUOTED.replace(",", sign).replace(".", ","), {"units": "g"}, "decimals with a point")
      for sign in (";", " ", "\t")),
    (QUOTED.replace(".", ","), {"units": "g"}, "without quotes"),
    # units that layouts and plain text state; digitised film has its own times
    (usc(), {"units": "g"}, 'got "g", allowed "g/10"'),
    (TENTHS, {"units": "g", "dt": STEP}, 'got "g", allowed "g/10"'),
    (TENTHS, {"dt": STEP}, (0, 0.1 * G)),
    (UNEVEN, {}, 'samples equally far apart, or kind = "table"'),
    (cosmos("cm/sec2 (2)"), {"column": 1}, "code 2"),
    (cosmos("counts (50)"), {"column": 1}, "units of counts"),
    (esm().replace("DATA_TYPE: ACC", "DATA_TYPE: NO ACC"), {}, 'got data of "NO", allowed ACC'),
    (esm().replace("UNITS: cm/s^2", "UNITS: cm/s"), {}, "got units of cm/s, allowed acceler"),
    # PEER: the last line with NPTS counts; numbers that touch
    (OLD + fixed(WAVES[0], 5, "15.6E"), {}, (0, G)),
    (peer().replace(peer().splitlines()[5], "  1.25-100.5 3.50-2.125 -1.0"), {},
     "finite numbers that do not touch"),
    # digits that are missing from a scale or a unit show in the peak, counts in lengths
    (knet().replace("/6182761", "/618276"), {}, "got a peak of 2.806, allowed 28.06, the largest"),
    (esm().replace("2: 19.9", "2: 9.9"), {}, "got a peak of 9.9, allowed 23.37, the largest of"),
    (IN_G, {"column": 1}, "the largest of the values"),
    (esm().replace("DURATION_S: 0.4", "DURATION_S: 0.8"), {}, ": line "),
    (geonet().replace("points  40", "points  44"), {"column": 1}, ": line "),
    (geonet().replace("of 0.010", "of 0.005"), {"column": 1}, ": line "),
]  # fmt: skip
"""Text, keys of the scene, and the words of the refusal, or which wave in which unit it is."""


@pytest.mark.parametrize(("text", "options", "right"), RULES)
def test_rules(
    folder: Path, text: str, options: dict[str, Any], right: str | tuple[int, float]
) -> None:
    if isinstance(right, str):
        assert right in refusal(folder, text, **options)
    else:
        motion = record(folder, text, **options)
        expected = np.array(WAVES[right[0]]) * right[1]
        np.testing.assert_allclose(motion.value, expected, rtol=1e-6, atol=1e-9)
        assert motion.step == pytest.approx(STEP)


@pytest.mark.parametrize("offset", [0.0, -200.0, 200.0])
def test_numbers_that_touch(folder: Path, offset: float) -> None:
    values = [value + offset for value in WAVES[0]]
    text = peer().partition("NPTS")[0] + f"NPTS= {COUNT}, DT= .01\n" + fixed(values, 8, "10.5f")
    assert offset != -200 or ("-19" in text and " " not in text.splitlines()[4].strip())
    motion = record(folder, text, "m.AT2")
    np.testing.assert_allclose(motion.value, G * np.array(values), rtol=1e-7)


def test_tables(folder: Path) -> None:
    """Uneven times are theirs; without a word of units they are g, another word has to be clear."""
    file = folder / "table.csv"
    body = "\n".join(f"{0.1 * i * i:.1f},{v}" for i, v in enumerate(WAVES[0]))
    for header, unit in (("", G), ("t,a\n", G), ("t,a (gal)\n", 0.01)):
        file.write_text(header + body)
        motion = read_table(TableSpec(file=file))
        np.testing.assert_allclose(motion.value, unit * np.array(WAVES[0]))
        assert motion.step is None
    file.write_text("Trigger level (gal): 4\n" + body)
    with pytest.raises(SceneError, match="units is required"):
        read_table(TableSpec(file=file))
    file.write_text(UNEVEN)
    motion = read_table(TableSpec(file=file))
    assert motion.step is None and motion.time[1] == pytest.approx(0.012)
    np.testing.assert_allclose(motion.value, 0.1 * G * np.array(WAVES[0]), atol=1e-12)


class TestObspy:
    """Records read by obspy, through a module that stands for it: it is not installed here."""

    BINARY = b"\x00\x01SAC"

    @staticmethod
    def trace(name: str, **changed: Any) -> Any:
        stats = SimpleNamespace(delta=STEP, calib=1.0)
        stats.__dict__.update(changed)
        return SimpleNamespace(id=name, data=np.array(WAVES[0], dtype=np.float32), stats=stats)

    def read(self, folder: Path, monkeypatch: Any, traces: list[Any], **options: Any) -> Any:
        monkeypatch.setitem(sys.modules, "obspy", SimpleNamespace(read=lambda name: traces))
        (folder / "m.sac").write_bytes(self.BINARY)
        return read_record(RecordSpec(file=folder / "m.sac", **options))

    def test_without_it(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "obspy", None)
        (folder / "m.sac").write_bytes(self.BINARY)
        for form in (None, "obspy"):
            with pytest.raises(SceneError, match=r"binary data, allowed .* \(pip install obspy\)"):
                read_record(RecordSpec(file=folder / "m.sac", format=form))

    def test_with_it(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        traces = [self.trace("XX.A..HNE"), self.trace("XX.A..HNN", delta=0.02)]
        options: dict[str, Any] = {"units": "m/s2", "column": "xx.a..hne"}
        motion = self.read(folder, monkeypatch, traces, **options)
        np.testing.assert_allclose(motion.value, WAVES[0], rtol=1e-6)
        assert motion.step == STEP and motion.source.startswith("by obspy: 40 samples")
        assert self.read(folder, monkeypatch, traces, units="g", column=2).step == 0.02
        for given_traces, wanted, match in (
            (traces, {"units": "g"}, "motion.column"),
            (traces[:1], {}, "motion.units is required"),
            ([traces[0], traces[0]], {"units": "g"}, "several traces of XX.A..HNE"),
            ([self.trace("A", calib=2.0)], {"units": "g"}, "a factor 2 of its own"),
        ):
            with pytest.raises(SceneError, match=match):
                self.read(folder, monkeypatch, given_traces, **wanted)


def test_the_log_of_a_run_says_what_was_read(folder: Path) -> None:
    """The same words as `rockslip check`, for each direction."""
    (folder / "m.NS").write_text(knet())
    record = {"kind": "record", "file": "m.NS", "scale": 2.0}
    content = {
        "block": [{"width": 0.5, "height": 1.0, "density": 2000.0, "model": "rigid"}],
        "motion": record | {"vertical": record},
        "time": {"end": 0.02, "step": 1e-3},
        "output": {"fields": "none"},
    }
    simulate(parse_scene(content, folder=folder), folder=folder / "run")
    log = (folder / "run" / "run.log").read_text()
    mean = float(np.mean(COUNTS)) * 3920 / 6182761
    said = (
        "K-NET, KiK-net: 40 samples, 0.01 s apart (line 11), component N-S, "
        f"counts times 3920/6182761, mean of {mean:.4g} cm/s2 removed, in cm/s2 (line 14), "
        "times 2 (scale)"
    )
    assert f"  motion: {said}\n" in log and f"  motion.vertical: {said}\n" in log


def test_the_page_lists_all_layouts() -> None:
    """docs/motions.md has a row for each."""
    page = (Path(__file__).parents[2] / "docs" / "motions.md").read_text()
    assert [name for name in get_args(Format) if f"| `{name}` |" not in page] == []


CASES = Path(__file__).parents[3] / "shared" / "cases"
RIGHT: list[tuple[str, dict[str, Any], float | str]] = [
    ("three.txt", {}, "3 columns (N-S, E-W, U-D)"),
    ("three.txt", {"column": "E-W", "units": "g"}, 0.06),
    ("words.txt", {}, 0.3),
    ("trigger.txt", {"units": "g"}, 0.3),
    ("trigger.txt", {}, "motion.units is required"),
    ("counts.txt", {}, 400 * 3920 / 6182761 / 981),
    ("quoted.csv", {"dt": None}, 0.2992),
    ("touching.AT2", {}, 0.28094),
    ("matched.AT2", {}, 0.0595),
    ("numeric_header.V1A", {}, "400 values, as line 8 says"),
    ("decimal_comma.csv", {"dt": None}, "decimals with a point"),
    ("index_column.csv", {}, "row numbers"),
    ("four_columns.dat", {"dt": None}, "motion.column, 2 to 4"),
    ("four_columns.dat", {"dt": None, "column": 3}, 0.0595),
    ("esm.ASC", {}, 0.0595),
]


@pytest.mark.skipif(not CASES.is_dir(), reason="no files of motions here")
@pytest.mark.parametrize(("name", "options", "right"), RIGHT)
def test_shared_cases(name: str, options: dict[str, Any], right: float | str) -> None:
    """The right answers of ../shared/cases/README.md."""
    spec = RecordSpec(file=CASES / name, **({"dt": 0.01} | options))
    if isinstance(right, str):
        with pytest.raises(SceneError) as caught:
            read_record(spec)
        assert right in str(caught.value)
    else:
        motion = read_record(spec)
        assert motion.peak / G == pytest.approx(right, rel=1e-3)
