# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # A block on a frame in space
#
# A deck of concrete stands on four columns that are fixed at their feet. The ground gives it one
# push along x and a weaker one along y. The block on the deck holds at first, then slides, aslant.
#
# This demo illustrates how to:
#
# - mesh a frame in space and let a block slide on it,
# - shake the ground in two directions,
# - say what the mesh has to do with the oscillator that an engineer would put in its place.
#
# ## What it is compared with
#
# First the frame alone. Each of its columns bends between two ends that do not turn, or hardly:
# its stiffness is $12 E I/h^3$, the deck and 13/35 of the columns move,
#
# $$ k = 4 \frac{12 E I}{h^3}, \qquad m = m_\text{deck} + 4 \frac{13}{35} m_\text{column}, \qquad
#    T = 2 \pi \sqrt{m/k} . $$
#
# The longest period of the mesh is longer by 1 %, because the deck bends a little and the columns
# end in it.
#
# Then frame and block. The scene is run again with `kind = "oscillator"` and a rigid block, by the
# engine of rigid blocks: a platform of the mass $m$ and with the period of the mesh, but no mesh.
# Slips of 250 mm agree within 1 %. Drifts of 4 mm are up to 6 % larger on the frame: the ground
# shakes half of its columns where 13/35 count as inertia, which makes 1.4 %, and its deck leans.

# +
import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np
from matplotlib.figure import Figure

from demos.program import demo, judged, output_of, run_scene
from demos.verdict import kept
from rockslip import Scene, load_scene, parse_scene
from solver.build.foundation import natural_period
from solver.pictures.deformed import Instant, draw_deformed
from solver.pictures.style import BLUE, ORANGE, legend_above, new_figure, save, zero_line
from solver.results.runs import Run
from solver.scene.foundation import FrameSpec

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("frame")

MESH, OSCILLATOR = "meshed frame", "oscillator"
# -

# ## The oscillator in place of the frame


# +
def frame_of(scene: Scene) -> FrameSpec:
    """The frame of the scene."""
    assert isinstance(scene.foundation, FrameSpec)
    return scene.foundation


def swaying_mass(frame: FrameSpec) -> float:
    """Deck and 13/35 of the columns, kg."""
    deck = frame.deck.width * frame.deck.height * frame.deck.thickness
    column = frame.column.width * frame.column.thickness * frame.storey
    return frame.density * (deck + 4 * 13 / 35 * column)


def beam_period(frame: FrameSpec) -> float:
    """Period of the deck on columns that bend between ends which do not turn, s."""
    inertia = frame.column.thickness * frame.column.width**3 / 12
    stiffness = 4 * 12 * frame.young * inertia / frame.storey**3
    return float(2 * np.pi * np.sqrt(swaying_mass(frame) / stiffness))


def damping_ratio(scene: Scene, period: float) -> float:
    """That of stiffness-proportional damping at a period, beta omega/2."""
    assert scene.damping is not None
    return scene.damping.stiffness * np.pi / period


def oscillator(scene: Scene, period: float) -> Scene:
    """The scene with a platform of the frame's mass and period, and a rigid block."""
    tables = scene.to_dict()
    tables["foundation"] = {
        "kind": "oscillator",
        "mass": swaying_mass(frame_of(scene)),
        "period": period,
        "damping_ratio": damping_ratio(scene, period),
    }
    shape = ("name", "width", "height", "thickness", "mass")
    tables["block"] = [{key: tables["block"][0][key] for key in shape} | {"model": "rigid"}]
    del tables["damping"]
    return parse_scene(tables)


# -

# ## Running it


# +
def shake(folder: Path, *changes: str, comm: MPI.Intracomm = MPI.COMM_WORLD) -> list[Path]:
    """Run frame and oscillator, with other values changed or not; returns the folders."""
    scene = load_scene(SCENE, [*changes])
    plain = oscillator(scene, natural_period(scene))
    return [
        run_scene(scene, folder / MESH, SCENE, comm),
        run_scene(plain, folder / OSCILLATOR, SCENE, comm),
    ]


NAMES = {
    "platform.drift_m": "drift along x",
    "platform.drift_second_m": "drift along y",
    "block.slip_m": "slip along x",
    "block.slip_second_m": "slip along y",
}
# -

# ## Picture


# +
def picture(runs: list[Run], folder: Path) -> Path:
    """The frame at rest and at its largest drift, and both answers; returns the file."""
    return save(lambda: _drawn(runs), folder / "frame.png")


def _drawn(runs: list[Run]) -> Figure:
    figure = new_figure(6.2)
    above, below = figure.subfigures(2, 1, height_ratios=(3, 3))
    mesh = runs[0].history
    largest = float(mesh["time_s"][np.argmax(np.abs(mesh["platform.drift_m"]))])
    last = float(mesh["time_s"][-1])
    instants = [
        Instant(0.0, "at rest"),
        Instant(largest, "largest drift"),
    ]
    draw_deformed(above, runs[0], instants)
    panels = below.subplots(2, 2, sharex=True, sharey="row")
    for axes, (name, label) in zip(panels.flat, NAMES.items(), strict=True):
        for run, look in zip(
            runs, ({"color": BLUE}, {"color": ORANGE, "linestyle": (0, (3, 3))}), strict=True
        ):
            label_of = run.label if axes is panels[0, 0] else None
            axes.plot(run.history["time_s"], 1e3 * run.history[name], label=label_of, **look)
        axes.set_title(label, loc="left")
        axes.set_xlim(0, last)
        zero_line(axes)
    for axes in panels[:, 0]:
        axes.set_ylabel("(mm)")
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    legend_above(below)
    return figure


# -

# ## Checks
#
# Differences are those over the largest value along x.


# +
def checks(runs: list[Run]) -> list[tuple[bool, str]]:
    """Check the runs; a line for each check."""
    results = [line for run in runs for line in kept(run)]
    mesh, plain = runs
    period, beam = plain.scene.platform().period, beam_period(frame_of(mesh.scene))
    said = f"period of the mesh {period:.4f} s, of beams {beam:.4f} s, within 2 %"
    results.append((abs(period / beam - 1) < 0.02, said))
    scale = 0.0
    for name, label in NAMES.items():
        ours, theirs = mesh.history[name], plain.history[name]
        other = np.interp(mesh.history["time_s"], plain.history["time_s"], theirs)
        scale = scale if "second" in name else float(np.abs(theirs).max())
        if scale <= 1e-3:
            said = f"{label}: the largest is {1e3 * scale:.1g} mm, too little to compare"
            results.append((False, said))
            continue
        off = float(np.abs(ours - other).max()) / scale
        band = 0.06 if "drift" in name else 0.01
        said = f"{label}: both within {off:.2%} of {1e3 * scale:.1f} mm, at most {band:.0%}"
        results.append((off < band, said))
    return results


def show(folders: list[Path]) -> int:
    """Draw and check what stands in the folders; returns the exit code."""
    return judged("block_on_frame", folders, picture, checks)


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    return demo("block_on_frame", "A block on a frame in space.", OUTPUT, shake, show, arguments)


if __name__ == "__main__":
    sys.exit(main())
# -
