# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # A stack on a platform under a record
#
# Two squat blocks stand on each other, on a platform on a spring and a dashpot. The ground moves as
# a file says, in the format of the PEER database. The demo writes that file itself: a shaking of
# three periods that grows and dies away, with a peak of 0.45 g.
#
# This demo illustrates how to:
#
# - shake a scene by a recorded accelerogram,
# - put blocks on each other, each with its own friction,
# - run the same scene with elastic and with rigid blocks, which two different engines compute.
#
# ## What it is compared with
#
# Where friction holds, blocks and platform are one oscillator of the mass $m_P + m_1 + m_2$ on the
# spring and dashpot of the platform. Between its samples a record is a straight line, for which
# the motion of an oscillator is known exactly,
#
# $$ x_{n+1} = e^{A h} x_n + B_0 a_n + B_1 a_{n+1}, $$
#
# with $x = (u, \dot u)$; `scipy.signal` has the matrices (hold of first order). That is the check
# of the stack that holds. When both blocks slide there is no closed form in this demo: then elastic
# blocks, by finite elements and Nitsche's contact, stand beside rigid ones, whose engine has three
# unknowns a block and an impulse at each corner. They share the law of contact and nothing else.

# +
import sys
from pathlib import Path

from mpi4py import MPI

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import cont2discrete

from demos.program import demo, judged, output_of, run_scene
from demos.verdict import kept
from rockslip import Scene, load_scene
from solver.parallel import on_first_rank
from solver.pictures.style import BLUE, ORANGE, legend_above, new_figure, save, zero_line
from solver.results.runs import Run
from solver.run.folders import open_folder

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("stack")

G = 9.81
STEP, LENGTH, PEAK_G = 0.01, 2.5, 0.45  # s, s, g
PERIODS = ((0.35, 1.0, 0.0), (0.6, 0.8, 1.0), (0.9, 0.6, 2.0))  # s, share, phase

VARIANTS = {
    "held": ("lower.friction=5.0", "upper.friction=5.0"),
    "elastic": (),
    "rigid": ('lower.model="rigid"', 'upper.model="rigid"'),
}
# -

# ## The record
#
# Five lines of numbers a row, as PEER writes them, in g.


# +
def samples() -> np.ndarray:
    """The accelerogram, g: three sines that grow and die away."""
    time = np.arange(0.0, LENGTH + STEP / 2, STEP)
    shape = sum(share * np.sin(2 * np.pi * time / T + phase) for T, share, phase in PERIODS)
    shape *= np.sin(np.pi * time / LENGTH) ** 2
    return np.asarray(PEAK_G * shape / np.abs(shape).max())


def write_record(file: Path) -> Path:
    """Write the accelerogram as PEER does; returns the file."""
    values = [f"{value:.7E}" for value in samples()]
    rows = [" ".join(values[i : i + 5]) for i in range(0, len(values), 5)]
    head = [
        "PEER FORMAT, WRITTEN BY A DEMO OF ROCKSLIP",
        "THREE SINES THAT GROW AND DIE AWAY",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        f"NPTS= {len(values)}, DT= {STEP} SEC",
    ]
    file.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    return file


# -

# ## Running it


# +
def shake(folder: Path, *changes: str, comm: MPI.Intracomm = MPI.COMM_WORLD) -> list[Path]:
    """Run all variants under the record, with other values changed or not; returns the folders."""

    def prepare() -> Path:
        open_folder(folder)
        return write_record(folder.resolve() / "record.AT2")

    record = on_first_rank(comm, prepare)
    return [
        run_scene(_scene(record, *variant, *changes), folder / name, SCENE, comm)
        for name, variant in VARIANTS.items()
    ]


def _scene(record: Path, *changes: str) -> Scene:
    """The scene under a record."""
    return load_scene(SCENE, [f'motion.file="{record}"', *changes])


def held_drift(scene: Scene, times: np.ndarray) -> np.ndarray:
    """Drift of platform and stack as one mass under the record, exact at its samples, m."""
    platform = scene.platform()
    mass = platform.mass + scene.carried_mass
    matrix = np.array([[0.0, 1.0], [-platform.stiffness / mass, -platform.damping / mass]])
    system = (matrix, np.array([[0.0], [-1.0]]), np.eye(2), np.zeros((2, 1)))
    a, b, c, d, _ = cont2discrete(system, STEP, method="foh")
    count = int(np.ceil(times[-1] / STEP)) + 1
    ground = np.zeros(count)
    ground[: len(samples())] = (G * samples())[:count]
    state, drift = np.zeros(2), np.empty(count)
    for step, value in enumerate(ground):
        drift[step] = (c @ state + d[:, 0] * value)[0]
        state = a @ state + b[:, 0] * value
    return np.asarray(np.interp(times, STEP * np.arange(count), drift))


# -

# ## Picture


# +
def picture(runs: list[Run], folder: Path) -> Path:
    """Ground, drift, and slips of both blocks; returns the file."""
    return save(lambda: _drawn(runs), folder / "stack.png")


def _drawn(runs: list[Run]) -> Figure:
    held, elastic, rigid = runs
    figure = new_figure(5.8)
    panels = figure.subplots(4, 1, sharex=True)
    panels[0].plot(STEP * np.arange(len(samples())), samples(), color="black", linewidth=0.8)
    time = held.history["time_s"]
    panels[1].plot(
        time, 1e3 * held_drift(held.scene, time), color=ORANGE, linewidth=3.0, alpha=0.6,
        label="one oscillator, exact",
    )  # fmt: skip
    panels[1].plot(
        time, 1e3 * held.history["platform.drift_m"], color="black", linewidth=0.8,
        label="stack that holds",
    )  # fmt: skip
    names = ("platform.drift_m", "lower.slip_m", "upper.slip_m")
    for run, look in (
        (elastic, {"color": BLUE}),
        (rigid, {"color": "red", "linestyle": (0, (2, 4))}),
    ):
        for axes, name in zip((panels[1], panels[2], panels[3]), names, strict=True):
            label = f"{run.label} blocks" if axes is panels[1] else None
            axes.plot(run.history["time_s"], 1e3 * run.history[name], label=label, **look)
    labels = ("ground (g)", "drift (mm)", "slip of the\nlower (mm)", "slip of the\nupper (mm)")
    for axes, label in zip(panels, labels, strict=True):
        axes.set_ylabel(label)
        zero_line(axes)
    panels[-1].set(xlabel="time (s)", xlim=(0, time[-1]))
    legend_above(figure)
    return figure


# -

# ## Checks
#
# Slips are compared with their largest value.


# +
def checks(runs: list[Run]) -> list[tuple[bool, str]]:
    """Check the runs; a line for each check."""
    results = [line for run in runs for line in kept(run)]
    held, elastic, rigid = runs
    drift = held.history["platform.drift_m"]
    away = float(np.abs(drift - held_drift(held.scene, held.history["time_s"])).max())
    off = away / float(np.abs(drift).max())
    results.append((off < 0.005, f"held: drift within {off:.2%} of one oscillator's, 0.5 %"))
    for name in ("platform.drift_m", "lower.slip_m", "upper.slip_m"):
        ours, theirs = (run.history[name] for run in (elastic, rigid))
        other = np.interp(elastic.history["time_s"], rigid.history["time_s"], theirs)
        off = float(np.abs(ours - other).max() / np.abs(theirs).max())
        most = 1e3 * float(np.abs(theirs).max())
        good = off < 0.02 and most > 1.0
        results.append((good, f"{name}: up to {most:.1f} mm, both engines within {off:.2%}, 2 %"))
    return results


def show(folders: list[Path]) -> int:
    """Draw and check what stands in the folders; returns the exit code."""
    return judged("stack_under_record", folders, picture, checks)


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    described = "A stack on a platform under a record."
    return demo("stack_under_record", described, OUTPUT, shake, show, arguments)


if __name__ == "__main__":
    sys.exit(main())
# -
