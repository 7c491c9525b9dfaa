# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # A laboratory model of a deck bay
#
# A stack of three containers stands on a bay of a deck on four piles. A shaking table has room for
# a fifteenth of it: a deck of 400 mm on columns of 37 mm by 600 mm. What the model does is to be
# what the prototype does, and this demo runs both.
#
# This demo illustrates how to:
#
# - make the model of a prototype with `rockslip scale`, in two ways,
# - shake a frame in space in three directions, and rock and slide a block on it,
# - compare runs of different size.
#
# ## Similarity
#
# Gravity is the same in the laboratory, so that accelerations are. Lengths over 15 then take times
# over $\sqrt{15}$, and the motion of the table is that of the ground, 3.87 times as fast. The
# material of the model has
#
# - the density of the prototype and a fifteenth of its moduli (`--keep density`), or
# - the moduli of the prototype and 15 times its density: masses are added (`--keep young`).
#
# Both give the angle of the block, its slip over its half diagonal $R$ and the drift of the deck
# over $R$ over the same $p t$, $p = \sqrt{3 g/(4 R)}$. A rigid block knows no modulus but that of
# the frame below it. Here nothing is compared with a closed form: the same equations are solved at
# two scales, and what has a length, a time or a force in the program and is not scaled would show.
# What is left is round-off, and what friction and impacts make of it.

# +
import sys
from pathlib import Path
from typing import NamedTuple

from mpi4py import MPI

import numpy as np
from matplotlib.figure import Figure

from demos.program import demo, judged, output_of, run_scene
from demos.verdict import Results, kept
from rockslip import Scene, load_scene
from solver.parallel import on_first_rank
from solver.pictures.deformed import Instant, draw_deformed
from solver.pictures.style import (
    BLUE,
    GREEN,
    ORANGE,
    RED,
    legend_above,
    new_figure,
    save,
    zero_line,
)
from solver.results.runs import Run
from solver.run.folders import open_folder
from solver.run.rescale import rescaled
from solver.scene.scaling import Scale

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("laboratory")

LENGTHS = 15
"""Lengths of the prototype over those of the model."""

PROTOTYPE, SAME_DENSITY, SAME_MODULI = "prototype", "same density", "same moduli"


class Pair(NamedTuple):
    """A prototype, one of its models, and how far they may be apart."""

    block: str
    model: str
    band: float


PAIRS = (
    Pair("rigid", SAME_DENSITY, 1e-9),
    Pair("rigid", SAME_MODULI, 1e-9),
    Pair("elastic", SAME_DENSITY, 1e-6),
)

COLUMNS = {
    "block.angle_rad": "lean",
    "block.angle_z_rad": "turn about the vertical",
    "block.slip_m": "slip along x",
    "block.slip_second_m": "slip along y",
    "platform.drift_m": "drift along x",
    "platform.drift_second_m": "drift along y",
}
# -

# ## Models
#
# The samples of the ground's motion go into files beside the scene of a model, with its times.


# +
def model_of(scene: Scene, keeps: str, file: Path, comm: MPI.Intracomm) -> Scene:
    """The scene of a model, as `rockslip scale -o FILE` writes it; collective."""

    def write() -> None:
        open_folder(file.parent)
        file.unlink(missing_ok=True)
        rescaled(scene, Scale(1 / LENGTHS, "young" if keeps == SAME_MODULI else "density"), file)

    on_first_rank(comm, write)
    return load_scene(file)


def shake(folder: Path, *changes: str, comm: MPI.Intracomm = MPI.COMM_WORLD) -> list[Path]:
    """Run prototypes and models, with other values changed or not; returns the folders."""
    folders = []
    for block in dict.fromkeys(pair.block for pair in PAIRS):
        scene = load_scene(SCENE, [f'block.model="{block}"', *changes])
        folders.append(run_scene(scene, folder / f"{block} {PROTOTYPE}", SCENE, comm))
        for pair in (pair for pair in PAIRS if pair.block == block):
            name = f"{block} {pair.model}"
            model = model_of(scene, pair.model, folder / "models" / f"{name}.toml", comm)
            folders.append(run_scene(model, folder / name, SCENE, comm))
    return folders


# -

# ## Comparison


# +
def clock(run: Run) -> np.ndarray:
    """p t of the rows of a run."""
    frequency = run.scene.blocks[0].shape.frequency(run.scene.gravity)
    return np.asarray(frequency * run.history["time_s"])


def without_dimension(run: Run, column: str) -> np.ndarray:
    """A column of a run: angles as they are, lengths over the half diagonal."""
    size = run.scene.blocks[0].shape.half_diagonal if column.endswith("_m") else 1.0
    return np.asarray(run.history[column] / size)


def difference(model: Run, prototype: Run, column: str) -> np.ndarray:
    """A column of the model less that of the prototype, row by row."""
    return without_dimension(model, column) - without_dimension(prototype, column)


def pairs(runs: list[Run]) -> list[tuple[Pair, Run, Run]]:
    """Each pair with its model and its prototype."""
    found = {run.label: run for run in runs}
    return [
        (pair, found[f"{pair.block} {pair.model}"], found[f"{pair.block} {PROTOTYPE}"])
        for pair in PAIRS
    ]


def table(runs: list[Run]) -> str:
    """Bodies in the laboratory, and their peaks."""
    lines = [f"{'':22} {'deck':>9} {'column':>7} {'block':>9} {'E frame':>8} {'lasts':>7}  peaks"]
    for run in runs:
        spec, block = run.scene.to_dict()["foundation"], run.scene.blocks[0]
        lean, slip, drift = (
            float(np.abs(without_dimension(run, name)).max())
            for name in ("block.angle_rad", "block.slip_m", "platform.drift_m")
        )
        lines.append(
            f"{run.label:22} {spec['deck']['width']:7.3f} m {1e3 * spec['column']['width']:4.0f} mm"
            f" {block.shape.mass:6.1f} kg {spec['young'] / 1e9:4.1f} GPa"
            f" {run.scene.time.end:5.2f} s  lean {lean / block.shape.slenderness():.3f} alpha,"
            f" slip {slip:.4f} R, drift {drift:.4f} R"
        )
    return "\n".join(lines)


# -

# ## Picture
#
# The model at rest and where it leans most, and what model and prototype do over $p t$.


# +
def picture(runs: list[Run], folder: Path) -> Path:
    """Draw the model, the histories and their differences; returns the file."""
    return save(lambda: _drawn(runs), folder / "laboratory.png")


def _drawn(runs: list[Run]) -> Figure:
    figure = new_figure(7.2)
    above, below = figure.subfigures(2, 1, height_ratios=(3, 4))
    chosen = [each for each in pairs(runs) if each[0].model == SAME_DENSITY]
    model = chosen[-1][1]
    time, lean = model.history["time_s"], np.abs(model.history["block.angle_rad"])
    instants = [Instant(0.0, "at rest"), Instant(float(time[np.argmax(lean)]), "leans most")]
    draw_deformed(above, model, instants)
    panels = below.subplots(3, len(chosen), sharex=True, sharey="row", squeeze=False)
    for column, (pair, own, prototype) in zip(panels.T, chosen, strict=True):
        _draw_pair(column, own, prototype)
        column[0].set_title(f"{pair.block} block", loc="left")
        column[2].axhline(pair.band, color="black", linewidth=0.6, linestyle=(0, (3, 3)))
        column[2].set(xlabel="p t", xlim=(0, clock(own)[-1]), ylim=(1e-17, 1e-5))
    labels = "lean / alpha", "slip / R\nalong x", "model less\nprototype"
    for axes, label in zip(panels[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    legend_above(below)
    return figure


def _draw_pair(column: np.ndarray, model: Run, prototype: Run) -> None:
    """Lean and slip of a model over those of its prototype, and how far they are apart."""
    alpha = model.scene.blocks[0].shape.slenderness()
    shown = (("block.angle_rad", alpha), ("block.slip_m", 1.0))
    for axes, (name, size) in zip(column[:2], shown, strict=True):
        over = without_dimension(prototype, name) / size
        axes.plot(clock(prototype), over, color=ORANGE, linewidth=3, alpha=0.6, label=PROTOTYPE)
        own = without_dimension(model, name) / size
        axes.plot(clock(model), own, color=BLUE, linewidth=0.9, label=f"model, 1:{LENGTHS}")
        zero_line(axes)
        apart = np.abs(difference(model, prototype, name)) + 1e-18
        lean = size == alpha
        look = {
            "color": GREEN if lean else RED,
            "label": f"apart: {'lean' if lean else 'slip / R'}",
        }
        column[2].semilogy(clock(model), apart, linewidth=0.7, **look)


# -

# ## Checks


# +
def checks(runs: list[Run]) -> Results:
    """Check the runs, and that models do what prototypes do."""
    results = [line for run in runs for line in kept(run)]
    for pair, model, prototype in pairs(runs):
        name = f"{pair.block}, {pair.model}"
        if len(clock(model)) != len(clock(prototype)):
            results.append((False, f"{name}: {len(clock(model))} rows, not as many"))
            continue
        apart = float(np.abs(clock(model) / clock(prototype).clip(1e-300) - 1)[1:].max())
        results.append((apart < 1e-12, f"{name}: p t of all rows within {apart:.1e}, 1e-12"))
        off = {c: float(np.abs(difference(model, prototype, c)).max()) for c in COLUMNS}
        worst = max(off, key=lambda column: off[column])
        good = off[worst] < pair.band
        said = f"{name}: histories at most {off[worst]:.1e} apart ({COLUMNS[worst]})"
        results.append((good, f"{said}, {pair.band:.0e}"))
        shape = model.scene.blocks[0].shape
        lean = float(np.abs(model.history["block.angle_rad"]).max()) / shape.slenderness()
        slip = float(np.abs(without_dimension(model, "block.slip_m")).max())
        moved = f"{name}: leans {lean:.4f} alpha and slips {slip:.4f} R, above 0.005 and 0.01"
        results.append((lean > 0.005 and slip > 0.01, moved))
    return results


def show(folders: list[Path]) -> int:
    """Print, draw and check what stands in the folders; returns the exit code."""
    return judged("laboratory_model", folders, picture, checks, table)


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    described = "A laboratory model and its prototype."
    return demo("laboratory_model", described, OUTPUT, shake, show, arguments)


if __name__ == "__main__":
    sys.exit(main())
# -
