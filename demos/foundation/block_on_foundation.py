# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # A block that rocks on a meshed foundation
#
# The paper's block of granite is let go at three degrees, as in `demos/free_rocking`. Here it
# stands on a foundation that is meshed by Gmsh, as in the paper's Figures 3 and 4: the bottom of
# the block is the contact surface, the top of the foundation the target surface.
#
# This demo illustrates how to:
#
# - mesh a foundation that is held altogether, and see on which facets a block stands,
# - let the foundation deform instead, and see what that takes at an impact.
#
# ## Three floors
#
# All nodes of the paper's foundation are held. It cannot deform, and the motion has to be that on
# a rigid face (`meshed = false`), which knows no facets. A block that slides from facet to facet
# shows that these join without a seam. The third floor is held at its bottom only, and is of
# concrete: E = 30 GPa against 50 GPa of the granite. It takes its share at each impact.
#
# Before the first impact a block that does not slip has one degree of freedom, and Housner's
# equation says when it strikes. On the floors that cannot deform later impacts are compared with
# that equation and the restitution that each run has found. On concrete they come up to 0.4 %
# earlier: there the block lands on a floor that swings, which no restitution tells.

# +
import sys
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from demos.program import demo, judged, output_of, run_scene
from demos.verdict import kept
from rockslip import load_scene
from solver.pictures.meshes import FieldFiles, polygons
from solver.pictures.style import BLUE, ORANGE, legend_above, new_figure, save, zero_line
from solver.reference.housner import housner
from solver.results.runs import Run

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("foundation")

FLOORS = {
    "held mesh": (),
    "rigid face": ("foundation.meshed=false",),
    "held at its bottom": ("foundation.meshed=false", 'foundation.support="bottom"'),
}
# -

# ## Running it


# +
def rock(folder: Path, *changes: str, comm: MPI.Intracomm = MPI.COMM_WORLD) -> list[Path]:
    """Run the scene on each floor, with other values changed or not; returns the folders."""
    return [
        run_scene(load_scene(SCENE, [*floor, *changes]), folder / name, SCENE, comm)
        for name, floor in FLOORS.items()
    ]


def impacts(run: Run) -> np.ndarray:
    """Times (s) and restitutions of the impacts of a run, (n, 2); nan: not known."""
    found = run.summary["blocks"]["block"]["impacts"]
    rows = [(impact["time_s"], impact["restitution"]) for impact in found]
    return np.array(rows, dtype=float).reshape(-1, 2)


def exact_impacts(run: Run) -> np.ndarray:
    """Times at which a rigid block with the same mean restitution strikes, s.

    Where none is known yet, it is Housner's: that makes no difference to the first impact.
    """
    block, ratios = run.scene.blocks[0], impacts(run)[:, 1]
    known = np.log(ratios[~np.isnan(ratios)])
    mean = float(np.exp(known.mean())) if len(known) else None
    answer = housner(
        block.shape,
        gravity=run.scene.gravity,
        tilt=block.tilt,
        end=run.scene.time.end,
        step=1e-3,
        restitution=mean,
    )
    return np.asarray(answer.impacts)


def table(runs: list[Run]) -> str:
    """The impacts on each floor."""
    lines = [f"{'floor':20} impacts s, restitutions"]
    for run in runs:
        found = ", ".join(f"{time:.4f} {e:.4f}" for time, e in impacts(run))
        lines.append(f"{run.label:20} {found}")
    return "\n".join(lines)


# -

# ## Picture
#
# Block and foundation as they were let go and after the first impact, with the contact surface in
# blue and the target surface in orange, and the angle on all floors.


# +
def picture(runs: list[Run], folder: Path) -> Path:
    """Draw meshes and angles; returns the file."""
    return save(lambda: _drawn(runs), folder / "foundation.png")


def _drawn(runs: list[Run]) -> Figure:
    figure = new_figure(5.6)
    above, below = figure.subfigures(2, 1, height_ratios=(3, 2))
    files = FieldFiles(runs[0].folder / "fields.pvd")
    history = runs[0].history
    leaning = history["time_s"][np.argmin(history["block.angle_rad"])]
    panels = above.subplots(1, 2, sharey=True)
    for axes, index in zip(panels, (0, files.nearest([leaning])[0]), strict=True):
        _draw_meshes(axes, files, index)
        axes.set_title(f"t = {files.times[index]:.3g} s", loc="left")
        axes.set_xlabel("x (m)")
    panels[0].set_ylabel("y (m)")
    legend_above(above)
    axes = below.subplots()
    styles: list[dict[str, Any]] = [
        {"color": BLUE},
        {"color": "black", "linestyle": (0, (2, 3))},
        {"color": ORANGE},
    ]
    for run, style in zip(runs, styles, strict=True):
        angle = np.degrees(run.history["block.angle_rad"])
        axes.plot(run.history["time_s"], angle, label=run.label, **style)
    axes.set(xlabel="time (s)", ylabel="angle (degrees)", xlim=(0, runs[0].history["time_s"][-1]))
    zero_line(axes)
    legend_above(below)
    return figure


def _draw_meshes(axes: Any, files: FieldFiles, index: int) -> None:
    """The cells of both bodies and their surfaces of contact."""
    undeformed = dict(zip(files.names, files.read(0), strict=True))
    bodies = dict(zip(files.names, files.read(index), strict=True))
    for name, label, colour in (
        ("plate", "target surface", ORANGE),
        ("block", "contact surface", BLUE),
    ):
        cells = polygons(bodies[name])
        faces = [cell[:, :2] for cell in cells]
        axes.add_collection(
            PolyCollection(faces, facecolor="#eef1f5", edgecolor="#667788", linewidth=0.4)
        )
        edges = _surface(polygons(undeformed[name]), cells, top=name == "plate")
        axes.add_collection(LineCollection(edges, colors=colour, linewidths=2.4, label=label))
    axes.set(xlim=(-0.55, 0.55), ylim=(-0.33, 1.08), aspect="equal")
    axes.grid(False)


def _surface(before: list[np.ndarray], now: list[np.ndarray], *, top: bool) -> list[np.ndarray]:
    """Edges on the top of a body, or on its bottom, where they are now.

    They are found where the body leans least: in its own frame, by the corners of its cells.
    """
    corners = np.concatenate(before)[:, :2]
    along, normal = _axes(corners, top)
    level = corners @ normal
    edges = []
    for old, new in zip(before, now, strict=True):
        on = np.flatnonzero(np.isclose(old[:, :2] @ normal, level.max(), atol=1e-6))
        if len(on) == 2:
            order = on[np.argsort(old[on, :2] @ along)]
            edges.append(new[order, :2])
    return edges


def _axes(corners: np.ndarray, top: bool) -> tuple[np.ndarray, np.ndarray]:
    """Directions along a rectangle's bottom, or top, and out of it."""
    angle = 0.0 if top else np.radians(load_scene(SCENE).blocks[0].tilt_deg)
    along = np.array([np.cos(angle), -np.sin(angle)])
    normal = np.array([-along[1], along[0]])
    return along, normal if top else -normal


# -

# ## Checks
#
# Each is a line: what was found, what is allowed. Impacts are compared where there are any: runs
# that end before fail, and say so.


# +
def checks(runs: list[Run]) -> list[tuple[bool, str]]:
    """Check the runs; a line for each check."""
    results = []
    for run in runs:
        completed, *balance = kept(run)
        found = impacts(run)[:, 0]
        if not len(found):
            end = run.scene.time.end
            results += [completed, (False, f"{run.label}: no impact until {end:g} s"), *balance]
            continue
        exact = exact_impacts(run)
        count = min(len(found), len(exact), 1 if run.scene.foundation.is_meshed else 100)
        off = float(np.abs(found[:count] / exact[:count] - 1).max()) if count else np.inf
        results += [
            completed,
            (off < 0.002, f"{run.label}: {count} impacts within {off:.3%} of a rigid block's"),
            *balance,
        ]
    mesh, face, soft = (impacts(run) for run in runs)
    if not min(len(mesh), len(face), len(soft)):
        return results
    off = float(np.abs(mesh[:, 0] - face[:, 0]).max()) if len(mesh) == len(face) else np.inf
    results.append((off < 1e-6, f"impacts on held mesh and rigid face {off:.1e} s apart, 1e-6"))
    taken = face[0, 1] - soft[0, 1]
    said = f"concrete takes {taken:.4f} of the restitution, between 0.002 and 0.02"
    results.append((bool(0.002 < taken < 0.02), said))
    return results


def show(folders: list[Path]) -> int:
    """Print, draw and check what stands in the folders; returns the exit code."""
    return judged("block_on_foundation", folders, picture, checks, table)


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    described = "Rocking on a meshed foundation."
    return demo("block_on_foundation", described, OUTPUT, rock, show, arguments)


if __name__ == "__main__":
    sys.exit(main())
# -
