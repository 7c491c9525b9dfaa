# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # Free rocking of a granite block
#
# A block of granite, 0.25 m wide, 1 m high, 0.75 m thick and 503 kg heavy, is held at an angle
# of three degrees on one of its bottom corners and let go. It falls back, strikes the
# foundation, lifts off about the other corner, and rocks to rest. The block is the paper's; the
# answer it is measured against is Housner's (1963).
#
# This demo illustrates how to:
#
# - run a scene from Python and leave its history, summary, fields and pictures in a folder,
# - compare impacts with the rigid-body equation that `solver.reference` solves,
# - read from the summary how well energy was kept and where it went,
# - see what the size of the time step and the damping of the block do to the loss at an impact.
#
# ## Strong form
#
# All displacements $u$ are relative to the ground. With the deformation gradient
# $F = I + \nabla u$, the Green strain $E = (F^T F - I)/2$ and Hooke's law
# $S = \lambda\,\mathrm{tr}(E) I + 2\mu E$ (in plane strain) the block obeys
#
# $$ \rho \ddot u = \nabla\cdot(F S) + \rho g \quad\text{in the block}, $$
#
# and on its boundary, with the gap $g_N$ to the foundation, the tangential position $s$ on it,
# and the traction $T = F S N$, of which $T_n$ is a pressure and $T_t$ friction, the laws of
# Signorini and Coulomb:
#
# $$ g_N \ge 0, \quad T_n \ge 0, \quad T_n g_N = 0, \qquad
#    |T_t| \le \mu T_n, \quad \dot s = 0 \text{ or } T_t = -\mu T_n \dot s/|\dot s| . $$
#
# ## Weak form
#
# Nitsche's method says the same without inequalities and without multipliers. With a stiffness
# $\gamma_h = \gamma(\lambda + 2\mu)/h$ the traction that the foundation exerts is
#
# $$ l_n = [T_n - \gamma_h g_N]_+, \qquad
#    l_t = \text{the value nearest to } T_t - \gamma_h (s - s_\text{stick})
#    \text{ within } |l_t| \le \mu l_n , $$
#
# where $s_\text{stick}$ is the memory of where a point sticks. The displacement then satisfies,
# for all test functions $v$,
#
# $$ \int \rho \ddot u \cdot v + \int S : \delta E[v] - \int \rho g\cdot v
#    - \int_\Gamma l\cdot\Big(v - \frac{1}{\gamma_h} DT[v]\Big)
#    - \int_\Gamma \frac{1}{\gamma_h} T\cdot DT[v] = 0 . $$
#
# Contact points are the nodes of the bottom (Gauss-Lobatto quadrature), so that the block
# pivots about its very corner.
#
# ## Time stepping
#
# Generalized-alpha with $\rho_\infty = 0.8$, except for three things that decide whether such a
# block keeps its energy: contact forces act at the end of the step as impulses, outside of the
# alpha average; internal forces take the averaged strain at the gradient of the midpoint; and
# after each step contact is solved once more for the velocities. `docs/method.md` has the
# equations.
#
# ## The scene
#
# It stands in `scene.toml` beside this script: 6 x 16 bilinear quadrilaterals, E = 50 GPa,
# friction 0.7, 3 s. It says nothing of damping: the block has 2 % of critical at its first bending
# mode when it stands, beta_R = 3.74e-5 s. Nor does it say anything of the time step: steps are
# chosen so that each impact is resolved, 10 microseconds where a corner strikes and 10 milliseconds
# in the middle of a swing.

# +
import sys
from pathlib import Path

from mpi4py import MPI

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from demos.program import conclude, output_of, parser_of, run_scene
from demos.verdict import verdict
from rockslip import Scene, load_scene, read_run
from solver.pictures import pictures, style
from solver.pictures.deformed import draw_deformed, instants
from solver.reference.housner import RockingReference, housner
from solver.results.report import report
from solver.results.runs import Run

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("free_rocking")
# -

# ## Running it
#
# The folder of the results is made anew: what an earlier run left there is removed, by the same
# rules as with `rockslip run --force`. Every rank takes part in the run; rank 0 alone prints,
# draws and checks.


# +
def rock(scene: Scene, folder: Path, comm: MPI.Intracomm = MPI.COMM_WORLD) -> None:
    """Run a scene into a folder."""
    run_scene(scene, folder, SCENE, comm)


# -

# ## What it is compared with
#
# Housner's block is rigid, does not slide and pivots about its corners,
#
# $$ \ddot\theta = -p^2 \sin(\alpha\,\mathrm{sgn}\theta - \theta), \qquad
#    \dot\theta^+ = e\,\dot\theta^-, \qquad e = 1 - \tfrac32 \sin^2\alpha = 0.9118, $$
#
# with $\alpha = \arctan(B/H)$ and $p = \sqrt{3g/(4R)}$. The first impact does not depend on
# $e$: it has to be right before anything is said of losses. The later ones do, since every
# impact takes what it takes from the swings after it. Hence a second rigid block, whose $e$ is the
# one that was measured in a test of such a block.


# +
MEASURED = 0.936
"""Restitution in the test of Pena and others (2007), quoted from memory."""


def rigid(scene: Scene, restitution: float | None = None) -> RockingReference:
    """Housner's answer to the scene, with his restitution or another one."""
    block = scene.blocks[0]
    return housner(
        block.shape,
        gravity=scene.gravity,
        tilt=block.tilt,
        end=scene.time.end,
        step=1e-3,
        restitution=restitution,
    )


def impacts(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and restitutions of the impacts of a run."""
    found = run.summary["blocks"]["block"]["impacts"]
    times = np.array([impact["time_s"] for impact in found])
    return times, np.array([impact["restitution"] for impact in found], dtype=float)


def table(run: Run, reference: RockingReference, matched: RockingReference) -> str:
    """The first seven impacts beside those of rigid blocks."""
    times, restitutions = impacts(run)
    own, others = f"rigid, e {MEASURED:g}", "rigid, e 0.9118"
    lines = [f"impact   this run s   restitution {own:>17}   difference {others:>17}"]
    for k, (time, own, close, exact) in enumerate(
        zip(times[:7], restitutions, matched.impacts, reference.impacts, strict=False), start=1
    ):
        lines.append(
            f"{k:6} {time:12.4f} {own:13.4f} {close:17.4f} {time / close - 1:+12.3%} {exact:17.4f}"
        )
    return "\n".join(lines)


# -

# ## Step and damping
#
# A pressure wave travels up and down the block in 0.46 ms. Steps of one millisecond do not see
# an impact happen: what is lost in it is decided by the scheme. Steps that resolve it find a limit
# which they do not decide: what goes into vibration, and from there into the material. `--steps`
# runs the scene for 1.5 s with fixed steps of 1 and 0.1 ms, with a fourth and with four times the
# default's tolerance, and with a third and three times the damping (half a minute).


# +
VARIANTS = {
    "fixed steps of 1 ms": ("time.step=1e-3",),
    "fixed steps of 0.1 ms": ("time.step=1e-4",),
    "default": (),
    "four times the tolerance": ("time.tolerance=4e-3",),
    "a fourth of the tolerance": ("time.tolerance=2.5e-4",),
    "a third of the damping": ("damping.stiffness=1.2e-5",),
    "three times the damping": ("damping.stiffness=1.1e-4",),
}


def variants(folder: Path, comm: MPI.Intracomm = MPI.COMM_WORLD) -> list[Path]:
    """Run the scene with other steps and other damping, without fields; returns the folders."""
    folders = []
    for name, changes in VARIANTS.items():
        short = ("time.end=1.5", 'output.fields="none"')
        folders.append(folder / name)
        rock(load_scene(SCENE, overrides=(*short, *changes)), folders[-1], comm)
    return folders


def table_of_variants(runs: list[Run], reference: RockingReference) -> str:
    """The impacts up to 1.5 s, one row for each run."""
    lines = [f"{'':26} steps  impacts up to 1.5 s; their restitutions"]
    for run in runs:
        times, ratios = impacts(run)
        early = " ".join(f"{time:.4f}" for time in times)
        kept = " ".join(f"{e:.3f}" for e in ratios[:4])
        lines.append(f"{run.folder.name:26} {run.summary['cost']['steps']:5}  {early}; {kept}")
    early = " ".join(f"{time:.4f}" for time in reference.impacts if time < 1.5)
    return "\n".join([*lines, f"{'rigid block, Housner 1963':33} {early}; 0.912"])


# -

# ## Pictures
#
# `picture_run` draws the pictures of `rockslip plot`: angle, phase plane, forces and slip,
# energy, the deformed block. One more is composed for the README. It is the paper's Figure 7: there
# the amplitudes of finite elements come within 25 % of those of a test. The history of that test is
# not at hand; the rigid block with the restitution that was measured takes its place.


# +
BAND = 0.25
"""Part by which the paper's amplitudes differ from those of the test, at most."""


def overview(run: Run, reference: RockingReference, matched: RockingReference) -> Path:
    """The angle against time, and below it the block at four instants; returns the file."""
    file = run.folder / "free_rocking.png"
    with mpl.rc_context(style.STYLE):
        figure = Figure(figsize=(6.3, 5.4), layout="constrained")
        FigureCanvasAgg(figure)
        above, below = figure.subfigures(2, 1, height_ratios=(2, 3))
        axes = above.subplots()
        rigid_block = np.degrees(reference.angle)
        axes.plot(
            reference.time, rigid_block, color=style.ORANGE, linestyle=style.DASHES,
            label="rigid block, e = 0.912 (Housner 1963)",
        )  # fmt: skip
        measured = np.degrees(matched.angle)
        axes.fill_between(
            matched.time, (1 - BAND) * measured, (1 + BAND) * measured, color=style.GREEN,
            alpha=0.2, linewidth=0, label=f"± {BAND:.0%} of it, as paper and test differ",
        )  # fmt: skip
        axes.plot(
            matched.time, measured, color=style.GREEN, linestyle=":",
            label=f"rigid block, e = {MEASURED:g} as measured",
        )  # fmt: skip
        angle = np.degrees(run.history["block.angle_rad"])
        axes.plot(run.history["time_s"], angle, color=style.BLUE, label="elastic block, this run")
        axes.set(xlabel="time (s)", ylabel="rocking angle (°)", xlim=(0, run.scene.time.end))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize="small")
        draw_deformed(below, run, instants(run))
        figure.draw_without_rendering()  # a first layout of subfigures cuts labels off
        figure.savefig(file, dpi=160)
    return file


# -

# ## Checks
#
# Each is a line: what was found, what is allowed. One that fails ends the demo with exit code
# 1.


# +
def checks(run: Run, matched: RockingReference) -> list[tuple[bool, str]]:
    """Check the run; a line for each check."""
    times, restitutions = impacts(run)
    exact = matched.impacts[:5]
    results = []
    if not len(times):
        results.append((False, f"no impact until {run.scene.time.end:g} s"))
    elif len(times) < len(exact) or not len(exact):
        results.append((False, f"{len(times)} impacts, a rigid block has {len(exact)} or more"))
    for k, (time, expected) in enumerate(zip(times, exact, strict=False), start=1):
        good = abs(time / expected - 1) <= 0.002
        results.append((good, f"impact {k} at {time:.4f} s, {expected:.4f} s within 0.2 %"))
    known = restitutions[:4][np.isfinite(restitutions[:4])]
    spread = float(np.ptp(known)) if len(known) else np.inf
    energy, block = run.summary["energy"], run.summary["blocks"]["block"]
    slip, damping = 1e3 * block["residual_slip_m"], energy["loss_share"].get("damping", 0.0)
    gain, ledger = energy["largest_gain_fraction"], energy["ledger_error_fraction"]
    completed = run.summary["status"] == "completed"
    return [
        (completed, f"status of the run: {run.summary['status']}"),
        *results,
        (spread < 0.002, f"restitutions of impacts 1 to 4 differ by {spread:.4f}, at most 0.002"),
        (damping > 0.8, f"{damping:.0%} of the loss is damping, more than 80 %"),
        (gain < 1e-6, f"largest energy gain {gain:.1e} of the scale, below 1e-6"),
        (ledger < 1e-8, f"ledger error {ledger:.1e} of the scale, below 1e-8"),
        (abs(slip) < 2, f"residual slip {slip:+.2f} mm, less than 2 mm either way"),
    ]


def show(folder: Path, others: list[Path]) -> int:
    """Print, draw and check what stands in the folders; returns the exit code."""
    run = read_run(folder)
    reference, matched = rigid(run.scene), rigid(run.scene, MEASURED)
    print(f"\n{report(run.summary)}\n{table(run, reference, matched)}\n")
    files = [*pictures.picture_run(run), overview(run, reference, matched)]
    if others:
        runs = [read_run(other) for other in others]
        print(f"{table_of_variants(runs, reference)}\n")
        files += pictures.picture_runs(runs, folder)
    print(f"in {folder}:")
    print(f"  history.csv, summary.json, {', '.join(file.name for file in files)}")
    print("  fields.pvd for ParaView: paraview --script=open_in_paraview.py\n")
    return verdict("free_rocking", checks(run, matched))


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code, the same on every rank."""
    parser = parser_of("Free rocking of the paper's granite block.", OUTPUT)
    parser.add_argument("--steps", action="store_true", help="also with other steps and damping")
    options = parser.parse_args(arguments)

    def work() -> list[Path]:
        rock(load_scene(SCENE, options.set), options.output)
        return variants(options.output) if options.steps else []

    return conclude("free_rocking", work, lambda others: show(options.output, others))


if __name__ == "__main__":
    sys.exit(main())
# -
