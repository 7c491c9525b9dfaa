# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # Hertz's line contact
#
# An elastic disc is pressed on rigid, frictionless ground. Hertz (1882) found the pressure and the
# width of the contact in closed form; here they come from finite elements, for loads that rise
# sixteenfold.
#
# This demo illustrates how to:
#
# - pose a contact problem in Python that is not a scene: a body, its supports, what it touches,
# - solve a sequence of equilibria, each of which starts from the one before,
# - compare contact tractions with a closed form.
#
# It uses `benchmarks/verification/`, a small library of problems with known answers.
#
# ## The problem
#
# The disc has the radius $R$, Young's modulus $E$ and Poisson's ratio $\nu$, in plane strain. With
# the contact modulus $E^*$, $1/E^* = (1 - \nu^2)/E$, a load $P$ per metre of length gives a contact
# of half-width $a$ and an ellipse of pressure with the peak $p_0$:
#
# $$ a = \sqrt{\frac{4 P R}{\pi E^*}}, \qquad p_0 = \frac{2 P}{\pi a}, \qquad
#    p(x) = p_0 \sqrt{1 - x^2/a^2} . $$
#
# The formulas hold for small strain, $a/R \ll 1$: the largest $a/R$ below is 0.01. The numbers are
# those of a steel roller of 0.2 m in diameter.

# +
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.verification.hertz import HertzLine, centre_approach, contact_modulus
from benchmarks.verification.load_steps import Tractions, pressed
from benchmarks.verification.pressed_disc import disc_on_ground
from demos.program import conclude, output_of, parser_of
from demos.verdict import verdict
from solver.pictures.style import colour, legend_above, new_figure, save
from solver.scene.material import Material

OUTPUT = output_of("hertz")

STEEL = Material(young=2.1e11, poisson=0.3, density=7850.0)
RADIUS = 0.1  # R, m
HALF_WIDTHS = (0.25e-3, 0.5e-3, 0.75e-3, 1e-3)  # a, m; the load is proportional to the square of a

#: Number of facets on the largest half-width; the smallest one has a quarter of them.
FACETS = 32
# -

# ## Loads
#
# The loads are chosen by the half-widths that they make, $P = \pi E^* a^2 / (4 R)$.


# +
@dataclass(frozen=True)
class Pressed:
    """Contact under one load: what was found, and what Hertz's formulas give."""

    hertz: HertzLine
    found: Tractions

    @property
    def peak_error(self) -> float:
        """Relative error of the largest pressure."""
        return float(self.found.pressure.max() / self.hertz.peak_pressure - 1)

    @property
    def width_error(self) -> float:
        """Relative error of the half-width, which is taken from the second moment of pressure."""
        return self.found.half_width / self.hertz.half_width - 1


MODULUS = contact_modulus((STEEL.young, STEEL.poisson))


def closed_form(load: float) -> HertzLine:
    """Hertz's contact under a load P (N/m)."""
    return HertzLine(load=load, radius=RADIUS, modulus=MODULUS)


def load_of(half_width: float) -> float:
    """Load P (N/m) that makes a contact of half-width a (m)."""
    return np.pi * MODULUS * half_width**2 / (4 * RADIUS)


# -

# ## Solution
#
# `disc_on_ground` makes the lower half of the disc with Gmsh: quadrilaterals, of one size at the
# contact, growing away from it. The flat side on top is a support that is held in both directions,
# so that the disc can neither roll nor tilt. Contact points stand at the nodes of the round side,
# each of which carries a length of it; pressures are forces over these lengths.
#
# The support is moved down by the approach of the disc's centre to the ground,
#
# $$ \delta = \frac{P}{\pi E^*} \left( 2 \ln \frac{4 R}{a} - 1 \right) , $$
#
# (Johnson 1985, Eq. 5.57), then corrected until the contact carries the load. Each equilibrium is
# found by Newton's method with the conditions of Signorini at all points at once: gap $g \ge 0$,
# pressure $p \ge 0$, $p g = 0$.


# +
def press(half_widths: tuple[float, ...] = HALF_WIDTHS, facets: int = FACETS) -> list[Pressed]:
    """Press the disc under rising loads; returns the contact under each of them."""
    disc = disc_on_ground(STEEL, radius=RADIUS, half_width=max(half_widths), facets=facets)
    loads = [load_of(half_width) for half_width in half_widths]
    contacts = pressed(disc, loads, approach=lambda load: centre_approach(closed_form(load)))
    return [Pressed(closed_form(load), found) for load, found in zip(loads, contacts, strict=True)]


def table(contacts: list[Pressed]) -> str:
    """Pressures and half-widths beside Hertz's."""
    lines = ["load MN/m   peak MPa   Hertz MPa    error   half-width mm   Hertz mm    error"]
    for one in contacts:
        peak, half = one.found.pressure.max(), one.found.half_width
        lines.append(
            f"{1e-6 * one.hertz.load:9.4f} {1e-6 * peak:10.1f} "
            f"{1e-6 * one.hertz.peak_pressure:11.1f} {one.peak_error:+8.2%} "
            f"{1e3 * half:15.4f} {1e3 * one.hertz.half_width:10.4f} {one.width_error:+8.2%}"
        )
    return "\n".join(lines)


# -

# ## Picture
#
# Pressure along the contact, points from finite elements, lines from the closed form.


# +
def picture(contacts: list[Pressed], folder: Path) -> Path:
    """Draw the pressure under each load; returns the file."""
    folder.mkdir(parents=True, exist_ok=True)
    return save(lambda: _drawn(contacts), folder / "hertz.png")


def _drawn(contacts: list[Pressed]) -> Figure:
    figure = new_figure(3.6)
    axes = figure.subplots()
    for number, one in enumerate(contacts):
        half = one.hertz.half_width
        x = np.linspace(-half, half, 201)
        label = f"{1e-6 * one.hertz.load:.3g} MN/m"
        axes.plot(1e3 * x, 1e-6 * one.hertz.pressure(x), color=colour(number), label=label)
        shown = np.abs(one.found.position[:, 0]) < 1.1 * half
        at, pressure = one.found.position[shown, 0], one.found.pressure[shown]
        axes.plot(1e3 * at, 1e-6 * pressure, "o", color=colour(number), markersize=2.5)
    axes.set(xlabel="distance from the middle (mm)", ylabel="pressure (MPa)", ylim=(0, None))
    legend_above(figure)
    return figure


# -

# ## Checks
#
# The peak pressure is Hertz's within 1 % and the half-width within 0.5 %. What remains is the mesh,
# which is coarse for the smallest load, and the strain, which is not infinitely small.


# +
def checks(contacts: list[Pressed]) -> list[tuple[bool, str]]:
    """Check the contacts; a line for each check."""
    results = []
    for one in contacts:
        at = f"P = {1e-6 * one.hertz.load:.3g} MN/m"
        peak, width = one.peak_error, one.width_error
        results += [
            (abs(peak) <= 0.01, f"{at}: peak pressure {peak:+.2%} from Hertz's, within 1 %"),
            (abs(width) <= 0.005, f"{at}: half-width {width:+.2%} from Hertz's, within 0.5 %"),
        ]
    return results


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    description = "Hertz's line contact by finite elements."
    options = parser_of(description, OUTPUT, changes=False).parse_args(arguments)

    def show(contacts: list[Pressed]) -> int:
        print(f"\n{table(contacts)}\n\n{picture(contacts, options.output)}\n")
        return verdict("hertz", checks(contacts))

    return conclude("hertz", press, show)


if __name__ == "__main__":
    sys.exit(main())
# -
