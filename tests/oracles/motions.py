"""Motions of the ground: one earthquake in several layouts of files, tables, synthetic ones."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from tests.oracles import own
from tests.oracles.answers import SLIDER, slides
from tests.oracles.oracle import CASES, Numbers, Oracle, program, today, word
from tests.oracles.rigid_ground import SQUAT

STEP, COUNT = 0.02, 100
TIMES = STEP * np.arange(COUNT)
#: Made up: four periods that grow and die away, m/s2.
WAVE = np.round(0.55 * own.G * np.sin(4 * np.pi * TIMES) * np.sin(np.pi * TIMES / 2), 4)
GAL = [round(100 * float(a), 2) for a in WAVE]
COUNTS = [round(gal * 6182761 / 3920) + 1500 for gal in GAL]
README = "../shared/cases/README.md"


def packed(values: Iterable[float], columns: int, form: str) -> str:
    """Values in reading order, as Fortran writes them."""
    words = [format(value, form) for value in values]
    return "".join("".join(words[i : i + columns]) + "\n" for i in range(0, len(words), columns))


def peer(wave: Any, name: str = "000") -> str:
    """A file of the PEER database."""
    head = f"MADE UP\nNOWHERE, {name}\nACCELERATION TIME SERIES IN UNITS OF G\n"
    return f"{head}NPTS=  {COUNT}, DT=  .0200 SEC\n" + packed(wave / own.G, 5, "15.7E")


# fmt: off
KNET_HEAD = {
    "Origin Time": "2000/01/01 00:00:00", "Lat.": "41.0", "Long.": "142.5", "Depth. (km)": "30",
    "Mag.": "6.2", "Station Code": "XXX000", "Station Lat.": "41.0", "Station Long.": "141.0",
    "Station Height(m)": "10", "Record Time": "2000/01/01 00:00:15", "Sampling Freq(Hz)": "50Hz",
    "Duration Time(s)": "2", "Dir.": "N-S", "Scale Factor": "3920(gal)/6182761",
    "Max. Acc. (gal)": f"{max(abs(gal - np.mean(GAL)) for gal in GAL):.3f}",
    "Last Correction": "2000/01/01 00:00:15", "Memo.": "",
}
KNET = "".join(f"{k:18}{v}\n" for k, v in KNET_HEAD.items()) + packed(COUNTS, 8, "9d")
ESM = (
    "EVENT_NAME: MADE_UP\nEVENT_ID: X\nMAGNITUDE_W: 6.0\nNETWORK: XX\nSTATION_NAME: a\n"
    f"SAMPLING_INTERVAL_S: {STEP:.6f}\nNDATA: {COUNT}\nDURATION_S: {COUNT * STEP:.3f}\n"
    f"STREAM: HNE\nUNITS: cm/s^2\nPGA_CM/S^2: {max(map(abs, GAL))}\nHEADER_FORMAT: DYNA 1.2\n"
    "DATA_TYPE: ACCELERATION\n" + packed(GAL, 1, ".2f")
)
USC = (
    "FILE     0 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:\nNOWHERE   21\n"
    "COMP S05W                           9\n"
    "INSTR PERIOD =  .037 SEC  DAMPING =   .568  SENSITIVITY =   1.69CM/G    69\n"
    f"NO. OF POINTS =   {COUNT}      DURATION =    1.980 SEC          50\n"
    "UNITS ARE SEC AND G/10             22\nRMS ACCLN. OF COMPLETE RECORD =     .211 G/10\n"
    + packed([0] * 100, 16, "5d") + packed([0.0] * 50, 8, "10.3f")
    + packed(np.column_stack([TIMES, 10 * WAVE / own.G]).ravel(), 10, "7.3f")
)
CSV = "time [s],acceleration [m/s2]\n" + "".join(
    f"{t:.2f},{a}\n" for t, a in zip(TIMES, WAVE, strict=True))
THREE = "N-S E-W U-D\n" + "".join(f"{a / 2:.3f} {a:.3f} {a / 3:.3f}\n" for a in GAL)
PLAIN: dict[str, Any] = {"dt": STEP, "units": "cm/s2"}
# fmt: on


def shaken(name: str, text: str, **keys: Any) -> Oracle:
    """The sliding block under the earthquake from a file."""
    motion = {"kind": "record", "file": name, **keys}
    changes = {"motion": motion, "time.end": 2.5, "block.friction": 0.2}
    numbers = slides(3e-3, 0.2, 2.5, ground=own.sampled(TIMES, WAVE))
    return Oracle(f"file {name}", SQUAT, changes, numbers, files={name: text})


def windowed() -> Numbers:
    """From 0.5 to 1.5 s of the earthquake, twice as strong, 0.1 s after the start."""
    ground = own.sampled(TIMES[25:76] - 0.4, 2 * WAVE[25:76])
    answer = own.sliding(0.4, 2.0, ground=ground)
    return {"block.peak_slip_m": program(answer.peak_slip, SLIDER, rel=5e-3)}


def synthetic(name: str, peak: float, **keys: Any) -> Oracle:
    """A synthetic motion under a block that sticks."""
    motion = {"kind": "synthetic", "seed": 3, **keys}
    changes = {"motion": motion, "block.friction": 5.0, "time.end": 20.0, "time.step": 5e-3}
    source = "definition: the same keys give the same motion"
    numbers = {"peak base.acceleration_m_s2": today(peak, rel=1e-4, source=source)}
    return Oracle(f"synthetic, {name}", SQUAT, changes, numbers)


def case(name: str, right: float | str, **keys: Any) -> Oracle:
    """A file of ../shared/cases: its PGA in g, or a word of the refusal."""
    motion = {"kind": "record", "file": str(CASES / name), **keys}
    if isinstance(right, str):
        numbers = {"refusal": word(right, README)}
    else:
        numbers = {"peak base.acceleration_m_s2": program(right * own.G, README, rel=1e-3)}
    label = f"case {name}" + "".join(f", {k} {v}" for k, v in keys.items() if k != "dt")
    changes = {"motion": motion, "time.end": 4.0, "time.step": 5e-3, "block.friction": 5.0}
    return Oracle(label, SQUAT, changes, numbers, needs=CASES / name)


# fmt: off
PEER = peer(WAVE)
DT = {"dt": 0.01}
ORACLES = [
    shaken("peer.AT2", PEER), shaken("knet.NS", KNET), shaken("esm.ASC", ESM),
    shaken("usc.e0a", USC),
    shaken("two.csv", CSV), shaken("table.csv", CSV, kind="table"),
    shaken("one.txt", packed(GAL, 1, ".2f"), **PLAIN),
    shaken("three.txt", THREE, column="E-W", **PLAIN),
    Oracle("window, start and scale", SQUAT, {"block.friction": 0.4, "time.end": 2.0, "motion": {
        "kind": "record", "file": "a.AT2", "window": [0.5, 1.5], "scale": 2.0, "start": 0.1}},
        windowed, files={"a.AT2": PEER}),
    Oracle("a unit that the header denies", SQUAT,
        {"motion": {"kind": "record", "file": "a.AT2", "units": "m/s2"}},
        {"refusal": word("motion.units", "both values are known")}, files={"a.AT2": PEER}),
    Oracle("three columns, not said which", SQUAT,
        {"motion": {"kind": "record", "file": "a.txt", **PLAIN}},
        {"refusal": word("3 columns", "no guess")}, files={"a.txt": THREE}),
    synthetic("seed 3", 1.332197), synthetic("scaled", 3 * 1.332197, scale=3.0),
    case("three.txt", "3 columns", **DT), case("three.txt", 0.06, column="E-W", units="g", **DT),
    case("words.txt", 0.3, **DT), case("trigger.txt", 0.3, units="g", **DT),
    case("trigger.txt", "units", **DT), case("counts.txt", 400 * 3920 / 6182761 / 981, **DT),
    case("quoted.csv", 0.2992), case("touching.AT2", 0.28094), case("matched.AT2", 0.0595),
    case("numeric_header.V1A", "400 values", **DT), case("decimal_comma.csv", "decimal"),
    case("index_column.csv", "row number", **DT), case("four_columns.dat", "column"),
    case("four_columns.dat", 0.0595, column=3), case("esm.ASC", 0.0595),
]
