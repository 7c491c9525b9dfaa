"""Run the thirteen scenes of the gallery, draw each, and write docs/gallery.md.

./in-env python3 demos/gallery/gallery.py            # all, a minute or two
./in-env python3 demos/gallery/gallery.py drum cask  # some, without the page
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np

from rockslip import load_scene, read_run, simulate
from solver.pictures.deformed import Instant, deformed_figure
from solver.pictures.style import STYLE
from solver.results.runs import Run

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGE = ROOT / "docs" / "gallery.md"

RESOLUTION = 110
"""Pixels an inch of the pictures on the page."""

SCENES = {
    "triangle": "A gable of slate, a triangle with its top off the middle. "
    "Each edge has an arm of its own: it lifts at {right} g about the right one and at {left} g "
    "about the left one.",
    "trapezoid": "A trapezoid on its short side. "
    "It rocks on the ends of that side, which lie within its outline, up to {angle} degrees.",
    "pentagon": "A regular pentagon is pushed with 12 rad/s, and tumbles over to its next side. "
    "It keeps half of its spin where a side lands.",
    "l_shape": "A stair in the shape of an L, cut into two convex parts without a seam. "
    "It lifts at {left} g about the edge below its post and at {right} g about the other one.",
    "hexagon": "A hexagon rolls down an incline of 20 degrees, by {angle} degrees in 1.5 s.",
    "drum": "A drum of 48 facets lies on its side. "
    "It rolls as the ground shakes, by up to {angle} degrees.",
    "cask": "A cask on its end, a `profile` turned about its axis. "
    "It rocks over its rim, up to {angle} degrees, and rolls on it.",
    "bottle": "A bottle on a table that is shaken three times a second along one direction, and "
    "four times along the other.",
    "statue": "A statue from an STL file of 3648 triangles. "
    "Its mass, centre and inertia are those of the surface; contacts see the convex hull.",
    "cabinet": "A cabinet on four feet, which stand within its sides. "
    "It rocks on their outer edges, up to {angle} degrees.",
    "table": "A table with one foot that is 6 mm short. "
    "It tips between three feet and three others.",
    "containers": "Four empty containers of 20 feet, by name, on their corner castings and with "
    "twist-locks between them. "
    "The wind grows to 24 m/s from the side, and topples all of them together: statics says from "
    "21.2 m/s on.",
    "lamp": "A lamp of three materials, a `union` of foot, post and shade. "
    "It rocks up to {angle} degrees.",
}
"""What each scene shows; numbers are those of its run."""

EVEN = {"pentagon": 0.75, "hexagon": 1.5, "drum": 2.0, "table": 0.75}
"""Scenes that are drawn at even times up to this one, s, for they roll or tip."""

HEAD = """\
# Gallery: bodies as they are

Thirteen scenes with [shapes](scene.md#shapes) and [feet](scene.md#feet),
and with [containers](scene.md#containers).
All bodies are rigid, and each scene runs in seconds.
`./in-env python3 demos/gallery/gallery.py` runs all of them, draws them and writes this page.
One of them, with its film, is

    ./in-env rockslip run demos/gallery/cask.toml -o out
    ./in-env rockslip animate out

[The museum's question](museum.md), a vase on a pedestal on a table, has a page of its own.
"""


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(SCENES)}")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "output" / "gallery")
    options = parser.parse_args()
    if unknown := set(options.names) - set(SCENES):
        parser.error(f"no scene {', '.join(sorted(unknown))}")
    page = [HEAD]
    for name in options.names or SCENES:
        run = run_scene(name, options.output / name)
        draw(name, run, options.output / f"{name}.png")
        title = run.scene.title
        picture = f"![{title}, at some instants](pictures/gallery_{name}.png)"
        scene = f"Scene: [`demos/gallery/{name}.toml`](../demos/gallery/{name}.toml)"
        page.append(f"## {title}\n\n{words(name, run)}\n\n{picture}\n\n{scene}\n")
        sys.stdout.write(f"{name}: {run.summary['cost']['wall_s']:.1f} s\n")
    if not options.names:
        PAGE.write_text("\n".join(page), encoding="utf-8")


def run_scene(name: str, folder: Path) -> Run:
    """Run a scene into a folder, and read it back."""
    simulate(load_scene(HERE / f"{name}.toml"), folder=folder)
    return read_run(folder)


def words(name: str, run: Run) -> str:
    """What a scene shows, with the numbers of its run, a sentence a line."""
    block = run.scene.blocks[0]
    shape = block.shape
    entry = run.summary["blocks"][block.name]
    text = SCENES[name].format(
        angle=f"{math.degrees(entry['peak_angle_rad']):.3g}",
        right=f"{shape.uplift(1):.2f}",
        left=f"{shape.uplift(-1):.2f}",
    )
    return text.replace(". ", ".\n")


def draw(name: str, run: Run, file: Path) -> None:
    """The bodies at some instants."""
    times = np.linspace(0, EVEN[name], 4) if name in EVEN else []
    chosen = [Instant(float(time)) for time in times]
    with mpl.rc_context(STYLE):
        figure = deformed_figure(run, chosen)
        figure.savefig(file, dpi=RESOLUTION, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    main()
