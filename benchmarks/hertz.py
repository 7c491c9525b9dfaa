"""Hertz's line contact, half an elastic disc on rigid ground: how errors fall with the mesh.

    ./in-env python3 benchmarks/hertz.py

Writes `benchmarks/hertz.csv`. Three cases, each on meshes of several facets on the half-width:

- a/R 0.01 and 0.001, loads that move the end of the contact through one facet (errors depend on
  where in its facet it lies: mean of squares over these loads, largest value for peak and width);
- public: the case of dolfinx_contact (two discs R 8, E 200, nu 0.3, load 10; half a disc on rigid
  ground is one half of it), with facets of 0.104, 0.052 and 0.026 half-widths. With a/R 0.085 and
  pressures of 4 % of E* it is beyond small strain, where this program and Hertz's formulas part by
  2.4 % in the peak (in proportion to a/R); dolfinx_contact solves it with linear elasticity. So it
  stands here three times: with load 10, where `against_finest` is the error against this program's
  own pressure on the finest mesh; with load 10 in linear elasticity, of which displacements, gaps
  and load a millionth are the same problem; and at equal facets with a load that makes a/R 0.001.

Errors of the pressure are L2 norms over the line of contact over that of Hertz's pressure, between
points linear. `l2_nominal` is force on undeformed length, `l2` force on deformed length (nodes);
`l2_constant` likewise with one value for each facet, as dolfinx_contact writes pressures for P1.
Its published errors are 0.065, 0.036, 0.018, taken to be relative likewise.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.verification.hertz import HertzLine, centre_approach, contact_modulus
from benchmarks.verification.load_steps import Tractions, pressed
from benchmarks.verification.pressed_disc import disc_on_ground
from solver.contact.body_points import SurfaceState
from solver.contact.carriers import Plane
from solver.contact.kinematics import ContactKinematics
from solver.scene.material import Material
from solver.stepping.stepper import Stepper

Array = NDArray[np.float64]

TABLE = Path(__file__).with_suffix(".csv")
POISSON = 0.3
PHASES = 8


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


def small(ratio: float, facets: int, points: str) -> dict[str, Any]:
    """One mesh at a/R = ratio."""
    disc = Disc(radius=1.0, young=1.0, half=ratio, facet=ratio / facets, points=points)
    halves = ratio * (1 + np.arange(PHASES) / (PHASES * facets))
    loads = [float(load) for load in np.pi * disc.modulus * halves**2 / 4]
    pairs = zip(disc.pressed(loads), loads, strict=True)
    found = [errors(one, disc.hertz(load)) for one, load in pairs]
    row: dict[str, Any] = {"case": f"a/R {ratio}", "points": points, "facet_over_a": 1 / facets}
    for name in found[0]:
        values = np.array([each[name] for each in found])
        if points == "gauss" and name in ("peak", "l2", "l2_constant"):
            continue
        squared = name.startswith("l2")
        row[name] = np.sqrt(np.mean(values**2)) if squared else values[np.argmax(np.abs(values))]
    return row


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


def main() -> int:
    """Write the table."""
    rows = [
        small(ratio, facets, points)
        for ratio in (0.01, 0.001)
        for points in ("nodes", "gauss")
        for facets in (5, 10, 20, 40)
    ]
    rows += public(10.0) + public(10.0, share=1e-6) + public(10.0 * (0.001 / 0.0851) ** 2)
    names = list(dict.fromkeys(name for row in rows for name in row))
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, fieldnames=names)
        writer.writeheader()
        for row in rows:
            numbers = {k: v if isinstance(v, str) else f"{v:.4g}" for k, v in row.items()}
            writer.writerow(numbers)
    sys.stdout.write(TABLE.read_text(encoding="utf-8"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
