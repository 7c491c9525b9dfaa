"""Error against run time for eight scenes, with pictures; other programs' points beside ours.

    ./in-env python3 benchmarks/work_precision.py [NAME ...] [--repeat 3] [--families FAMILY ...]

T1 (elastic, rigid), T2, T3 and the scenes in space, on a meshed platform and rocking on a platform
are `rockslip study error-runtime` on `benchmarks/scenes/*.toml`;
Hertz's line contact has no scene and comes from `benchmarks/hertz.py`, judged and drawn by the same
code. Pictures go to `docs/pictures/error_*.png`, tables to `benchmarks/work_precision/`. Some
fifty minutes on a machine that is otherwise idle, which it should be.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.error_runtime.findings import Findings, read_beside
from benchmarks.error_runtime.ladders import NAMES, LadderFamily, Rung, RunOutcome, climb
from benchmarks.error_runtime.machine import machine
from benchmarks.error_runtime.picture import picture
from benchmarks.error_runtime.reference import Reference
from benchmarks.error_runtime.study import study
from benchmarks.error_runtime.table import as_csv, text
from benchmarks.hertz import PHASES, Disc, constant, true_pressure
from rockslip import load_scene
from solver.study.tables import write

HERE = Path(__file__).resolve().parent
SCENES, TABLES = HERE / "scenes", HERE / "work_precision"
PICTURES = HERE.parent / "docs" / "pictures"

#: What is drawn of each scene.
DRAWN = {
    "t1_elastic": ("first_impact", "third_impact"),
    "t1_rigid": ("first_impact", "third_impact", "angle_rad"),
    "t2": ("peak_drift", "residual_slip"),
    "t3": ("residual_slip",),
    "space": ("peak_slip",),
    "plate": ("peak_drift", "residual_slip"),
    "rocking_platform": ("first_impact", "peak_drift", "angle_rad"),
}

#: Families that are run of a scene where they are not all.
FAMILIES = {
    "space": ("step", "adaptive", "mesh", "model"),
    "plate": ("step", "adaptive", "mesh", "model"),
    "rocking_platform": ("step", "model"),
}

#: Scenes in the plane that slip as far as one in space; where to is another matter.
ANSWERED_BY = {"space": "t3"}

#: Scenes that other programs ran.
BESIDE = ("t1_elastic", "t1_rigid", "t2", "t3")

#: Steps in a ladder: 4 ms to 0.25 ms (t1_rigid: 16 ms to 1 ms).
RUNGS = 5

#: Half-width of the contact over the radius: small enough for Hertz's formulas.
RATIO = 0.001

#: Facets on the half-width.
FACETS = (5, 10, 20, 40)

#: Where pressures are compared, in half-widths.
AT = np.linspace(-1.5, 1.5, 6001)


def scene_findings(name: str, repeat: int, longest: float, families: Sequence[str]) -> Findings:
    """The study of a scene."""
    own, answer = FAMILIES.get(name, NAMES), ANSWERED_BY.get(name)
    return study(
        load_scene(SCENES / f"{name}.toml"),
        names=[family for family in families if family in own],
        wanted=DRAWN[name],
        rungs=RUNGS,
        repeat=repeat,
        longest=longest,
        others=read_beside(SCENES / "beside.csv") if name in BESIDE else (),
        answered_by=load_scene(SCENES / f"{answer}.toml") if answer else None,
        tell=lambda line: print(f"{name}: {line}", file=sys.stderr),
    )


def loads(disc: Disc, facets: int) -> list[float]:
    """Rising loads that move the end of the contact through one facet."""
    halves = disc.half * (1 + np.arange(PHASES) / (PHASES * facets))
    return [float(load) for load in np.pi * disc.modulus * halves**2 / (4 * disc.radius)]


def press(facets: int, points: str) -> RunOutcome:
    """One mesh under all loads; seconds are those of one load."""
    disc = Disc(radius=1.0, young=1.0, half=RATIO, facet=RATIO / facets, points=points)
    began = perf_counter()
    stepper = disc.stepper()
    ready = perf_counter()
    forces = loads(disc, facets)
    contacts = list(disc.pressed(forces, stepper))
    ended = perf_counter()
    linear, level, peaks = [], [], []
    for found, load in zip(contacts, forces, strict=True):
        hertz, x = disc.hertz(load), found.position[:, 0]
        at = AT * hertz.half_width
        # At nodes on deformed lengths, at Gauss points as they are.
        pressure = true_pressure(found) if points == "nodes" else found.pressure
        linear.append(np.interp(at, x, pressure) / hertz.peak_pressure)
        level.append(constant(x, pressure, at) / hertz.peak_pressure)
        peaks.append(pressure.max() / hertz.peak_pressure)
    measures = {"contact.pressure": np.concatenate(linear), "contact.peak": np.array(peaks)}
    if points == "nodes":
        measures["contact.facet_pressure"] = np.concatenate(level)
    return RunOutcome(
        measures=measures,
        loop_s=(ended - ready) / len(forces),
        setup_s=ready - began,
        counts={"unknowns": stepper.system.size},
    )


def hertz_findings(repeat: int, longest: float) -> Findings:
    """Findings for Hertz's line contact, by facets on the half-width."""
    families = [
        LadderFamily(
            name=f"points {points}",
            size="facets",
            rungs=tuple(
                Rung(
                    setting=f"{facets} facets",
                    size=1 / facets,
                    work=float(facets),
                    solve=partial(press, facets, points),
                )
                for facets in FACETS
            ),
        )
        for points in ("nodes", "gauss")
    ]
    trials, left_out = climb(
        families,
        repeat=repeat,
        longest=longest,
        tell=lambda trial: print(f"hertz: {trial.rung.setting}", file=sys.stderr),
    )
    exact = np.tile(np.sqrt(np.maximum(1 - AT**2, 0)), PHASES)
    ellipse = Reference(
        value=exact, uncertainty=0.0, scale=float(np.linalg.norm(exact)), source="Hertz"
    )
    peak = Reference(
        value=np.ones(PHASES), uncertainty=0.0, scale=float(np.sqrt(PHASES)), source="Hertz"
    )
    names = {
        "contact.pressure": "contact pressure, linear between points, L2",
        "contact.facet_pressure": "contact pressure, one value a facet, L2",
        "contact.peak": "peak pressure",
    }
    return Findings(
        title=f"Hertz's line contact, half a disc on rigid ground, a/R {RATIO:g}; time of one load",
        machine=machine(),
        repeat=repeat,
        trials=trials,
        left_out=left_out,
        references={
            "contact.pressure": ellipse,
            "contact.facet_pressure": ellipse,
            "contact.peak": peak,
        },
        names=names,
        others=[p for p in read_beside(SCENES / "beside.csv") if p.measure in names],
    )


def main() -> int:
    """Run what is asked for, write tables and pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    names = (*DRAWN, "hertz")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(names)}; all")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--longest", type=float, default=60.0, help="leave out longer runs, s")
    parser.add_argument("--families", nargs="+", default=NAMES, choices=NAMES, metavar="FAMILY")
    options = parser.parse_args()
    if unknown := set(options.names) - set(names):
        parser.error(f"{', '.join(unknown)}: choose among {', '.join(names)}")
    TABLES.mkdir(exist_ok=True)
    for name in options.names or names:
        if name in DRAWN:
            findings = scene_findings(name, options.repeat, options.longest, options.families)
        else:
            findings = hertz_findings(options.repeat, options.longest)
        write(TABLES / f"{name}.csv", as_csv(findings))
        write(TABLES / f"{name}.txt", text(findings))
        picture(findings, PICTURES / f"error_{name}.png", list(findings.names))
        print(text(findings))
    return 0


if __name__ == "__main__":
    sys.exit(main())
