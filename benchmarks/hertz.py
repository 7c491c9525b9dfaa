"""Hertz's line contact, half an elastic disc on rigid ground: how errors fall with the mesh.

    ./in-env python3 benchmarks/hertz.py

At a/R 0.001 by 5 to 40 facets on the half-width, as errors against run time: tables in
`benchmarks/work_precision/`, and `docs/pictures/error_hertz.png`. Loads move the end of the contact
through one facet, since errors depend on where in its facet it lies; they are means of squares over
these loads.

And the case of dolfinx_contact (two discs R 8, E 200, nu 0.3, load 10; half a disc on rigid ground
is one half of it), with facets of 0.104, 0.052 and 0.026 half-widths, in `benchmarks/hertz.csv`.
With a/R 0.085 and pressures of 4 % of E* it is beyond small strain, where this program and Hertz's
formulas part by 2.4 % in the peak (in proportion to a/R); dolfinx_contact solves it with linear
elasticity. So it stands here three times: with load 10, where `against_finest` is the error against
this program's own pressure on the finest mesh; with load 10 in linear elasticity, of which
displacements, gaps and load a millionth are the same problem; and at equal facets with a load that
makes a/R 0.001.

Errors of the pressure are L2 norms over the line of contact over that of Hertz's pressure, between
points linear. `l2_nominal` is force on undeformed length, `l2` force on deformed length (nodes);
`l2_constant` likewise with one value for each facet, as dolfinx_contact writes pressures for P1.
Its published errors are 0.065, 0.036, 0.018, taken to be relative likewise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.error_runtime.findings import Findings, read_beside
from benchmarks.error_runtime.ladders import RunOutcome, climb, ladder
from benchmarks.error_runtime.machine import machine
from benchmarks.error_runtime.picture import picture
from benchmarks.error_runtime.reference import Reference
from benchmarks.error_runtime.table import as_csv, text
from benchmarks.verification.hertz import HertzLine, centre_approach, contact_modulus
from benchmarks.verification.load_steps import Tractions, pressed
from benchmarks.verification.pressed_disc import disc_on_ground
from solver.contact.body_points import SurfaceState
from solver.contact.carriers import Plane
from solver.contact.kinematics import ContactKinematics
from solver.scene.material import Material
from solver.stepping.stepper import Stepper
from solver.study import tables

Array = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
POISSON = 0.3

RATIO = 0.001
"""Half-width of the contact over the radius: small enough for Hertz's formulas."""
FACETS = (5, 10, 20, 40)
PHASES = 8
"""Loads that move the end of the contact through one facet."""

JUDGED = {
    "contact.pressure": "contact pressure, linear between points, L2",
    "contact.facet_pressure": "contact pressure, one value a facet, L2",
    "contact.peak": "peak pressure",
}
ERRORS = {
    "nodes": {"contact.pressure": "l2", "contact.facet_pressure": "l2_constant",
              "contact.peak": "peak"},
    "gauss": {"contact.pressure": "l2_nominal", "contact.peak": "peak_nominal"},
}  # fmt: skip
"""Names of the errors in `hertz.csv` by those of the measures, for each kind of points."""


class NearGround(Plane):
    """Level ground to which all points are as many times nearer as strains are to be smaller."""

    def __init__(self, share: float):
        """Take the share of its gap that each point keeps."""
        level = Plane.level(2)
        super().__init__(level.reference_frame, level.origin)
        self.share = share
        self.places: Array | None = None
        """Places of the points on the undeformed body, (points, 2), m."""

    def kinematics(
        self, position: Array, carrier: SurfaceState | None, frame: Array
    ) -> ContactKinematics:
        """Gaps and tangential positions of points in space."""
        if self.places is not None:
            position = position - (1 - self.share) * self.places * (0.0, 1.0)
        return super().kinematics(position, carrier, frame)


@dataclass(frozen=True, kw_only=True)
class Disc:
    """Half a disc and its contact with rigid ground; the flat side is moved as a whole.

    `share` is what displacements, gaps and forces are multiplied by: in linear elasticity it is the
    same problem, and a small one makes elasticity linear.
    """

    radius: float
    young: float
    half: float
    facet: float
    points: str = "nodes"
    share: float = 1.0

    @property
    def modulus(self) -> float:
        """E*."""
        return contact_modulus((self.young, POISSON))

    def hertz(self, load: float) -> HertzLine:
        """Closed form."""
        return HertzLine(load=load, radius=self.radius, modulus=self.modulus)

    def stepper(self) -> Stepper:
        """The body in contact."""
        ground = NearGround(self.share)
        stepper = disc_on_ground(
            Material(young=self.young, poisson=POISSON, density=1.0),
            radius=self.radius,
            half_width=self.half,
            facets=self.half / self.facet,
            points=self.points,
            ground=ground,
        )
        stepper.start(np.zeros(stepper.system.size), np.zeros(stepper.system.size))
        ground.places = stepper.links[0].interface.points.reference
        return stepper

    def pressed(
        self, loads: Sequence[float], stepper: Stepper | None = None
    ) -> Iterator[Tractions]:
        """Contact under loads one after another.

        Args:
            loads: Rising, N/m.
            stepper: Result of `stepper()`, unless it is to be made here.
        """

        def approach(load: float) -> float:
            return self.share * centre_approach(self.hertz(load / self.share))

        shares = [load * self.share for load in loads]
        for found in pressed(stepper or self.stepper(), shares, approach=approach):
            yield replace(found, force=found.force / self.share)


def true_pressure(found: Tractions) -> Array:
    """Force of points at nodes on the deformed length between the middles to their neighbours."""
    x, force = found.position[:, 0], found.force[:, 0]
    ends = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    return force / np.diff(ends)


def constant(x: Array, values: Array, at: Array) -> Array:
    """Means over the facets between x of what is linear there."""
    facet = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    return 0.5 * (values[1:] + values[:-1])[facet]


def l2(x: Array, values: Array, reference: Array, at: Array) -> float:
    """L2 norm of the error of `values` at x, linear between them, over that of the reference."""
    off = np.interp(at, x, values) - reference
    return float(np.linalg.norm(off) / np.linalg.norm(reference))


def errors(found: Tractions, hertz: HertzLine) -> dict[str, float]:
    """Relative errors of one contact."""
    x = found.position[:, 0]
    at = np.linspace(-1.5, 1.5, 30001) * hertz.half_width
    pressure, exact = true_pressure(found), hertz.pressure(at)
    means = constant(x, pressure, at)
    return {
        "peak_nominal": found.pressure.max() / hertz.peak_pressure - 1,
        "peak": pressure.max() / hertz.peak_pressure - 1,
        "half_width": found.half_width / hertz.half_width - 1,
        "l2_nominal": l2(x, found.pressure, exact, at),
        "l2": l2(x, pressure, exact, at),
        "l2_constant": float(np.linalg.norm(means - exact) / np.linalg.norm(exact)),
    }


def press(facets: int, points: str) -> RunOutcome:
    """Errors on one mesh under all loads; seconds are those of one load."""
    disc = Disc(radius=1.0, young=1.0, half=RATIO, facet=RATIO / facets, points=points)
    halves = RATIO * (1 + np.arange(PHASES) / (PHASES * facets))
    loads = [float(load) for load in np.pi * disc.modulus * halves**2 / 4]
    began = perf_counter()
    stepper = disc.stepper()
    ready = perf_counter()
    contacts = list(disc.pressed(loads, stepper))
    ended = perf_counter()
    found = [errors(one, disc.hertz(load)) for one, load in zip(contacts, loads, strict=True)]
    return RunOutcome(
        measures={
            name: np.array([each[key] for each in found]) for name, key in ERRORS[points].items()
        },
        loop_s=(ended - ready) / PHASES,
        setup_s=ready - began,
        counts={"unknowns": stepper.system.size},
    )


def against_run_time() -> Findings:
    """Errors against run time, by facets on the half-width."""
    meshes = [(f"{facets} facets", 1 / facets, float(facets), facets) for facets in FACETS]
    families = [
        ladder(f"points {points}", "facets", meshes, partial(press, points=points))
        for points in ERRORS
    ]
    trials, left_out = climb(families, repeat=3, longest=60.0)
    exact = Reference(
        value=np.zeros(PHASES), uncertainty=0.0, scale=float(np.sqrt(PHASES)), source="Hertz"
    )
    others = read_beside(HERE / "scenes" / "beside.csv")
    return Findings(
        title=f"Hertz's line contact, half a disc on rigid ground, a/R {RATIO:g}; time of one load",
        machine=machine(),
        repeat=3,
        trials=trials,
        left_out=left_out,
        references=dict.fromkeys(JUDGED, exact),
        names=JUDGED,
        others=[other for other in others if other.measure in JUDGED],
    )


def public(load: float, share: float = 1.0) -> list[dict[str, Any]]:
    """The case of dolfinx_contact; the last mesh is what the others are compared with, too."""
    rows, contacts = [], []
    modulus = contact_modulus((200.0, POISSON))
    half = HertzLine(load=load, radius=8.0, modulus=modulus).half_width
    for facet in (0.104, 0.052, 0.026, 0.013):
        disc = Disc(radius=8.0, young=200.0, half=half, facet=facet * half, share=share)
        contacts.append(next(disc.pressed([load])))
        found = errors(contacts[-1], disc.hertz(load))
        name = f"public, load {load:.3g}" + (" linear" if share < 1 else "")
        case = {"case": name, "points": "nodes", "facet_over_a": facet}
        rows.append({**case, **found})
    finest, at = contacts[-1], np.linspace(-1.5, 1.5, 30001) * half
    reference = np.interp(at, finest.position[:, 0], finest.pressure)
    for row, one in zip(rows[:-1], contacts[:-1], strict=True):
        row["against_finest"] = l2(one.position[:, 0], one.pressure, reference, at)
    return rows


def main() -> None:
    """Write the tables and the picture."""
    rows = public(10.0) + public(10.0, share=1e-6) + public(10.0 * (0.001 / 0.0851) ** 2)
    tables.write(HERE / "hertz.csv", tables.as_csv(rows, tables.column_names(rows), digits=4))
    findings = against_run_time()
    tables.write(HERE / "work_precision" / "hertz.csv", as_csv(findings))
    tables.write(HERE / "work_precision" / "hertz.txt", text(findings))
    picture(findings, HERE.parent / "docs" / "pictures" / "error_hertz.png", list(JUDGED))
    print(text(findings))


if __name__ == "__main__":
    main()
