# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # A container yard
#
# Containers stand on a deck on piles, one alone or up to four on each other. The ground shakes the
# deck. Which stacks slide, which rock, and how much of their weight does the deck feel?
#
# This demo illustrates how to:
#
# - make a family of scenes out of one,
# - put blocks on each other, or lock them to one,
# - find by a slow ramp when a block begins to move, and how.
#
# ## What is assumed
#
# A container is 2.44 m wide, 2.59 m high and 6.06 m long (20 feet). Empty it weighs 2.3 t, full
# 30.48 t, and its load is spread evenly. Steel on steel or on concrete has friction between 0.2
# and 0.4. The bay of the deck stands alone: 6 m from edge to edge, 0.5 m of concrete (E = 30 GPa,
# 2500 kg/m³) on piles that are fixed 9 m below it. They are square with 0.55 m, which bend as
# octagonal ones of 24 inches do, a usual size, with half of that modulus for their cracks. Loss is
# 5 % of critical at the first sway of the empty deck. Water and soil take no part.
#
# ## What is known
#
# A block of width $B$ and height $H$ on level ground begins to move under the acceleration
#
# $$ a = g \min\left(\mu, \frac{B}{H}\right), $$
#
# and slides if $\mu < B/H$, else it lifts. That does not depend on its weight. A stack of $n$
# containers of height $h$ that are locked to each other has $B/H = B/(n h)$: 0.942, 0.471, 0.314
# and 0.236. If they stand on each other freely, the same friction is exhausted everywhere at once,
# and they lift at their bottom first, where all of them turn. So with friction up to 0.4 only
# stacks of three and more can rock, and those of three need more than 0.31.

# +
import csv
import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

from mpi4py import MPI

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from demos.program import demo, judged, output_of, run_scene
from demos.verdict import Results, all_kept
from rockslip import Scene, load_scene, parse_scene, simulate
from solver.build.foundation import natural_period
from solver.parallel import on_first_rank
from solver.pictures.meshes import FieldFiles, polygons
from solver.pictures.style import BLUE, GREY, ORANGE, RED, new_figure, save
from solver.results.runs import Run
from solver.run.folders import open_folder

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("yard")

EMPTY = 2300.0  # kg
FRICTIONS = (0.2, 0.3, 0.4)
MOST = 4
COUNTS_FROM = 0.01
"""A slip counts from this part of the width, a lean from this part of alpha: decks bend."""
ONSETS = "onsets.csv"


class Stack(NamedTuple):
    """Some containers, and how they stand."""

    containers: int
    friction: float = 0.4
    full: bool = True
    locked: bool = True

    @property
    def name(self) -> str:
        """Name that differs from those of all others."""
        how = "locked" if self.locked or self.containers == 1 else "free"
        return f"{self.containers} {'full' if self.full else 'empty'} {how} {self.friction:g}"


COUNTS = range(1, MOST + 1)

SHAKEN = (
    *(Stack(count) for count in COUNTS),
    *(Stack(count, locked=False) for count in COUNTS if count > 1),
    *(Stack(count, full=False) for count in COUNTS),
    *(Stack(count, friction=0.2) for count in COUNTS),
)
"""The stacks that the earthquake shakes."""

RAMPED = tuple(
    Stack(count, friction, locked=locked)
    for friction in FRICTIONS
    for count in COUNTS
    for locked in ((True, False) if count > 1 else (True,))
)
"""Those on slowly accelerated ground."""
# -

# ## Scenes


# +
def tables_of(scene: Scene, stack: Stack) -> dict[str, Any]:
    """The tables of a scene with a stack in place of its container."""
    tables = scene.to_dict()
    (one,) = tables["block"]
    one["mass"] = one["mass"] if stack.full else EMPTY
    count = stack.containers
    blocks = [one | {"height": count * one["height"], "mass": count * one["mass"]}]
    if not stack.locked:
        names = ["foundation", *(f"container{k + 1}" for k in range(count))]
        blocks = [one | {"name": names[k + 1], "on": names[k]} for k in range(count)]
    return tables | {"block": blocks, "contact": {"friction": stack.friction}}


def slenderness(run: Run) -> float:
    """B/H of all containers of a run together."""
    blocks = run.scene.blocks
    return blocks[0].width / sum(block.height for block in blocks)


# -

# ## How they begin to move
#
# Rigid ground is accelerated more and more, by half a sine of 24 s. The run ends when something
# has begun: a slip of a nanometre or a turn of a nanoradian, of whichever block comes first.


# +
def onset(scene: Scene, stack: Stack) -> tuple[str, float, float]:
    """Mode in which a stack begins to move; acceleration at which it does, and should, over g."""
    tables = tables_of(scene, stack)
    (width, height) = (scene.blocks[0].width, stack.containers * scene.blocks[0].height)
    expected, strength, length = min(stack.friction, width / height), 0.6, 24.0
    end = length / math.pi * math.asin(1.05 * expected / strength)
    tables |= {
        "foundation": {"kind": "rigid"},
        "motion": {"kind": "half_sine", "amplitude_g": strength, "duration": length},
        "time": {"end": end, "step": 2e-3},
    }
    history = simulate(parse_scene(tables)).history
    first = {"rest": len(history)}
    for block in tables["block"]:
        for how, column in (("rock", "angle_rad"), ("slide", "slip_m")):
            moved = np.flatnonzero(np.abs(history[f"{block['name']}.{column}"]) > 1e-9)
            first[how] = min([first.get(how, len(history)), *moved[:1]])
    how = min(first, key=lambda key: first[key])
    row = min(first[how], len(history) - 1)
    return how, float(history["base.acceleration_m_s2"][row]) / scene.gravity, expected


def ramp(folder: Path, comm: MPI.Intracomm) -> None:
    """Write how stacks begin to move; all ranks compute the same."""
    scene = load_scene(SCENE)
    found = [(stack, *onset(scene, stack)) for stack in RAMPED]

    def write() -> None:
        open_folder(folder)
        with (folder / ONSETS).open("w", encoding="utf-8", newline="") as stream:
            rows = csv.writer(stream)
            rows.writerow(["containers", "locked", "friction", "begins", "at_g", "expected_g"])
            for stack, how, at, expected in found:
                own = stack.containers, stack.locked, stack.friction
                rows.writerow([*own, how, f"{at:.5f}", f"{expected:.5f}"])

    on_first_rank(comm, write)


def onsets(runs: list[Run]) -> list[dict[str, str]]:
    """Table of the onsets of motion of the stacks, as it was written."""
    with (runs[0].folder.parent / ONSETS).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


# -

# ## Under the earthquake


# +
def shake(folder: Path, *changes: str, comm: MPI.Intracomm = MPI.COMM_WORLD) -> list[Path]:
    """Run all stacks, with other values of the scene or not; returns the folders of the shaken."""
    ramp(folder, comm)
    scene, folders = load_scene(SCENE, [*changes]), []
    for stack in SHAKEN:
        own = parse_scene(tables_of(scene, stack))
        folders.append(run_scene(own, folder / stack.name, SCENE, comm))
    return folders


def fate(run: Run) -> str:
    """The most that any container did: stay, slide, rock or fall."""
    modes = {entry["mode"] for entry in run.summary["blocks"].values()}
    if modes & {"overturned", "fell"}:
        return "fall"
    if farthest(run, "peak_angle_rad") > COUNTS_FROM * math.atan(slenderness(run)):
        return "rock"
    slides = farthest(run, "peak_slip_m") > COUNTS_FROM * run.scene.blocks[0].width
    return "slide" if slides else "stay"


def felt(run: Run) -> float:
    """The part of a stack's mass that the deck felt, 1 if it were bolted down.

    With this part fixed to the deck, inertia would do the same work on the drift of the whole run.
    """
    history, first = run.history, run.scene.blocks[0]
    drift, step = run.history["platform.drift_m"], history["step_s"]
    acceleration = history["base.acceleration_m_s2"] + history["platform.acceleration_m_s2"]
    pushed = float(np.sum(step * history[f"{first.name}.friction_force_N"] * drift))
    return pushed / (run.scene.carried_mass * float(np.sum(step * acceleration * drift)))


def farthest(run: Run, entry: str) -> float:
    """The largest of the containers' peaks."""
    return max(float(block[entry]) for block in run.summary["blocks"].values())


def ramp_table(runs: list[Run]) -> str:
    """Onsets of motion of the stacks."""
    rows = onsets(runs)
    heads = "".join(f"{f'mu {friction:g}':>16}" for friction in FRICTIONS)
    lines = [f"begins to move at, over g   B/H{heads}"]
    for count in COUNTS:
        for locked in (True, False) if count > 1 else (True,):
            own = [r for r in rows if (r["containers"], r["locked"]) == (f"{count}", f"{locked}")]
            told = "".join(f"{row['begins']:>10} {float(row['at_g']):.3f}" for row in own)
            ratio = runs[0].scene.blocks[0].width / runs[0].scene.blocks[0].height / count
            lines.append(f"{count} {'locked' if locked else 'free':20} {ratio:8.3f}{told}")
    return "\n".join(lines)


def table(runs: list[Run]) -> str:
    """Onsets of motion of the stacks, and the effects of the earthquake on them."""
    lines = ["earthquake             B/H  fate    slip mm  lean deg  deck drift mm  weight felt"]
    for run in runs:
        slip, lean = farthest(run, "peak_slip_m"), farthest(run, "peak_angle_rad")
        drift = run.summary["platform"]["peak_drift_m"]
        lines.append(
            f"{run.label:20} {slenderness(run):5.3f}  {fate(run):6} {1e3 * slip:8.1f}"
            f" {math.degrees(lean):9.2f} {1e3 * drift:14.1f} {100 * felt(run):10.0f} %"
        )
    empty = natural_period(runs[0].scene)
    return "\n".join([ramp_table(runs), "", *lines, f"period of the empty deck {empty:.2f} s"])


# -

# ## Picture
#
# Above, the full stacks with friction 0.4 as they stand when they have moved farthest, true to
# scale, and where they stood (dotted). Below, how they begin to move, and what the deck feels.


# +
PAINT = ("#b5472d", "#2f6690", "#4c7a4a", "#d39b3a")


def picture(runs: list[Run], folder: Path) -> Path:
    """Draw the yard; returns the file."""
    return save(lambda: _drawn(runs), folder / "yard.png")


def _drawn(runs: list[Run]) -> Figure:
    figure = new_figure(5.4)
    above, below = figure.subfigures(2, 1, height_ratios=(7, 6))
    shown = [run for run in runs if " full " in run.label and run.label.endswith(" 0.4")]
    shown.sort(key=lambda run: run.label.split(" ")[0] + run.label.split(" ")[2][::-1])
    panels = above.subplots(1, len(shown), sharex=True, sharey=True)
    for axes, run in zip(panels, shown, strict=True):
        _draw_stack(axes, run)
    left, right = below.subplots(1, 2)
    _draw_onsets(left, onsets(runs))
    _draw_felt(right, runs)
    return figure


def _draw_stack(axes: Any, run: Run) -> None:
    """The deck and its stack where the stack has moved farthest."""
    history, scene, fields = run.history, run.scene, run.fields
    assert fields is not None
    files = FieldFiles(fields)
    column = "angle_rad" if fate(run) in ("rock", "fall") else "slip_m"
    moved = np.max([np.abs(history[f"{block.name}.{column}"]) for block in scene.blocks], axis=0)
    (index,) = files.nearest([float(history["time_s"][np.argmax(moved)])])
    row = int(np.argmin(np.abs(history["time_s"] - files.times[index])))
    bodies = dict(zip(files.names, files.read(index), strict=True))
    floor = -(scene.foundation.depth or 0.0)
    axes.axhspan(floor, -2.2, color="#cfe3ef", zorder=0)
    axes.axhspan(floor - 2, floor, color="#b9a88a", zorder=0)
    for name, body in bodies.items():
        if not name.startswith("container"):
            faces = [cell[:, :2] for cell in polygons(body)]
            axes.add_collection(PolyCollection(faces, facecolor="#8d9299", edgecolor="#8d9299"))
    for number, (start, now) in enumerate(zip(_boxes(run, 0), _boxes(run, row), strict=True)):
        axes.add_collection(
            PolyCollection([start], facecolor="none", edgecolor=GREY, linestyle=":", linewidth=0.7)
        )
        _draw_container(axes, now, PAINT[number % len(PAINT)])
    count, _, how, _ = run.label.split(" ")
    what = {"stay": "stays", "slide": "slides", "rock": "rocks", "fall": "falls"}[fate(run)]
    far = f"{1e3 * moved.max():.0f} mm"
    if column == "angle_rad":
        far = f"{math.degrees(moved.max()):.1f}°"
    far = "" if what == "stays" else f" {far}"
    axes.set_title(f"{count} {how if count != '1' else 'alone'}\n{what}{far}", fontsize=8)
    axes.set(xlim=(-4.0, 4.0), ylim=(floor - 1, 11.5), aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)


def _boxes(run: Run, row: int) -> list[np.ndarray]:
    """Corners of all containers at a row of the history, from the lowest upwards, m, (4, 2)."""
    found = []
    height = load_scene(SCENE).blocks[0].height
    for block in run.scene.blocks:
        count = round(block.height / height)
        values = [run.history[f"{block.name}.{c}"][row] for c in CENTRE]
        turn = np.array([[math.cos(values[2]), math.sin(values[2])]])
        turn = np.vstack([turn, [[-turn[0, 1], turn[0, 0]]]])
        for k in range(count):
            low = -block.height / 2 + k * height
            sides = np.array([-1, 1, 1, -1]) * block.width / 2
            corners = np.stack([sides, [low, low, low + height, low + height]], axis=1)
            found.append(np.array(values[:2]) + corners @ turn.T)
    return found


CENTRE = ("centre_x_m", "centre_y_m", "angle_rad")


def _draw_container(axes: Any, corners: np.ndarray, colour: str) -> None:
    """A box with the ribs of its end wall."""
    axes.add_collection(
        PolyCollection([corners], facecolor=colour, edgecolor="black", linewidth=0.7, zorder=3)
    )
    left, right, top, other = corners
    for part in np.linspace(0.12, 0.88, 7):
        foot, head = left + part * (right - left), other + part * (top - other)
        inner = [foot + 0.1 * (head - foot), foot + 0.9 * (head - foot)]
        axes.plot(*np.transpose(inner), color="black", alpha=0.35, linewidth=0.5, zorder=4)


def _draw_onsets(axes: Any, rows: list[dict[str, str]]) -> None:
    """Accelerations at which stacks begin to move, beside the closed form."""
    scene = load_scene(SCENE).blocks[0]
    counts = np.array(COUNTS)
    axes.plot(counts, scene.width / scene.height / counts, color="black", label="B/H")
    for friction, tint in zip(FRICTIONS, (BLUE, ORANGE, RED), strict=True):
        own = [row for row in rows if float(row["friction"]) == friction]
        axes.axhline(friction, color=tint, linewidth=0.6, linestyle=(0, (3, 3)))
        for how, mark in (("slide", "s"), ("rock", "^")):
            at = [(int(r["containers"]), float(r["at_g"])) for r in own if r["begins"] == how]
            if at:
                label = f"{how}s" if friction == FRICTIONS[-1] else None
                axes.plot(*np.transpose(at), mark, color=tint, markersize=4.5, label=label)
        axes.text(
            4.7, friction, f"mu {friction:g}", color=tint, fontsize=7, va="bottom", ha="right"
        )
    axes.set(xlabel="containers", ylabel="begins to move at (g)", xlim=(0.7, 4.7), ylim=(0, 1))
    axes.set_xticks(counts)
    axes.legend(fontsize=7, handlelength=1.2)


def _draw_felt(axes: Any, runs: list[Run]) -> None:
    """The part of the weight that the deck feels, over the number of containers."""
    groups = {
        "full, mu 0.4": (" full locked 0.4", BLUE, "o-"),
        "full, mu 0.4, free": (" full free 0.4", BLUE, "o:"),
        "full, mu 0.2": (" full locked 0.2", ORANGE, "s-"),
        "empty, mu 0.4": (" empty locked 0.4", GREY, "^-"),
    }
    for label, (ending, tint, look) in groups.items():
        own = [run for run in runs if run.label.endswith(ending)]
        at = [(int(run.label[0]), 100 * felt(run)) for run in own]
        if at:
            axes.plot(*np.transpose(at), look, color=tint, markersize=4, label=label)
    axes.set(xlabel="containers", ylabel="weight that the deck feels (%)", xticks=list(COUNTS))
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=7, loc="lower left")


# -

# ## Checks


# +
def checks(runs: list[Run]) -> Results:
    """Check the runs; a line for each check."""
    rows = onsets(runs)
    off = max(abs(float(row["at_g"]) / float(row["expected_g"]) - 1) for row in rows)
    block = runs[0].scene.blocks[0]
    wrong = [
        row
        for row in rows
        if (row["begins"] == "rock")
        != (block.width / block.height / int(row["containers"]) < float(row["friction"]))
    ]
    results = [
        *all_kept(runs),
        (off < 0.005, f"{len(rows)} ramps: begin within {100 * off:.2f} % of min(mu, B/H), 0.5 %"),
        (not wrong, f"{len(rows)} ramps: lift where B/H < mu, else slide; {len(wrong)} do not"),
    ]
    return [*results, *_under_the_earthquake(runs)]


def _under_the_earthquake(runs: list[Run]) -> Results:
    """Check that the shaken stacks do what friction and slenderness allow."""
    able = [slenderness(run) < run.scene.friction_of(run.scene.blocks[0]).static for run in runs]
    rocks = [fate(run) in ("rock", "fall") for run in runs]
    most = max(_over_friction(run) for run in runs if len(run.scene.blocks) == 1)
    shares = {run.label: felt(run) for run in runs}
    slides = [run.label for run in runs if fate(run) == "slide"]
    pairs = [(name.replace(" 0.4", " 0.2"), name) for name in slides if name.endswith(" 0.4")]
    pairs = [pair for pair in pairs if pair[0] in slides]
    less = [shares[little] < shares[much] for little, much in pairs]
    against = sum(rock and not may for may, rock in zip(able, rocks, strict=True))
    return [
        (not against, f"{against} of {len(able) - sum(able)} stacks with B/H > mu rock, none may"),
        (any(rocks), f"{sum(rocks)} of {sum(able)} stacks with B/H < mu rock, at least one"),
        (most < 1e-9, f"friction over mu N by at most {max(most, 0):.1e} of a weight, 1e-9"),
        (
            bool(less) and all(less),
            "the deck feels less of each stack that slides with friction 0.2 than with 0.4",
        ),
    ]


def _over_friction(run: Run) -> float:
    """Largest excess over mu N of a locked stack's force along its deck, over its weight."""
    (own,) = run.scene.blocks
    force, normal = (run.history[f"{own.name}.{n}_force_N"] for n in ("friction", "normal"))
    over = np.abs(force) - run.scene.friction_of(own).static * normal
    return float(over.max()) / own.shape.weight(run.scene.gravity)


def show(folders: list[Path]) -> int:
    """Print, draw and check what stands in the folders; returns the exit code."""
    return judged("container_yard", folders, picture, checks, table)


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    described = "Stacks of containers on a deck on piles."
    return demo("container_yard", described, OUTPUT, shake, show, arguments)


if __name__ == "__main__":
    sys.exit(main())
# -
