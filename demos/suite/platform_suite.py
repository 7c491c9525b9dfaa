# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # A platform under thirty earthquakes
#
# A block stands on a platform that is half as heavy and shaken by thirty motions of the ground,
# one after the other, with four friction coefficients: 120 runs. What is asked is how far the
# platform moves. The paper does this in its Figure 6 and compares finite elements with an ordinary
# differential equation: the mean of the ratio is 0.98 there.
#
# This demo illustrates how to:
#
# - run one scene under many motions and with several values of a key, on all processors,
# - go on after an interruption without doing anything twice,
# - read the table of a suite, draw it and judge it.
#
# ## The scene
#
# It stands in `scene.toml` beside this script. The block is 1 m wide and 0.5 m high, too squat to
# rock, of 6 x 4 bilinear quadrilaterals with E = 50 GPa. The mass ratio is $m_L/m_P = 2$; the
# empty platform has the period $T_n$ = 0.5 s and the damping ratio $\xi$ = 0.05. The
# scene says nothing of the time step: steps are adaptive, 2.5 to 5 ms under strong shaking and
# less than a millisecond where the block begins and ends to slide. After the shaking they may be
# 20 ms long here, a twenty-fifth of the platform's period; by default they are at most a twentieth
# of the shortest period of the motion, which changes no ratio by more than 0.0013 and takes 1.8
# times the steps.
#
# The paper's platform is a plate of finite elements, 3 m long and 0.3 m thick, on rollers and a
# spring. `plate.toml` is the same scene on such a plate, and `--plate` runs it:
#
#     ./in-env python3 demos/suite/platform_suite.py --plate
#
# Its reference is the same: a plate on rollers is one mass on a spring, as far as it is stiff.
#
# ## The motions
#
# The paper's are recorded ones, of earthquakes of magnitude 6.5 to 6.9 at 20 to 30 km from the
# fault, on soil of NEHRP's classes C and D. Records belong to those who made them and are not in
# this repository. By default the motions are synthetic: drawn from the same ranges, made by
# filtering noise with the spectrum of a seismological model (`docs/synthetic.md`), each from a
# seed, so that they are the same everywhere. Records of your own take their place with
#
#     ./in-env python3 demos/suite/platform_suite.py --motions FOLDER
#
# Each motion is read or made in the process that runs it. Its run ends with it.
#
# ## What it is compared with
#
# As long as the block stays flat, block and platform obey
#
# $$ m_L (a_L + a_g) + f = 0, \qquad
#    m_P (a_P + a_g) + c\,v_P + k\,u_P - f = 0 , $$
#
# with $|f| \le \mu m_L g$ while the block sticks, $v_L = v_P$, and $f = \mu m_L g\,
# \mathrm{sgn}(v_L - v_P)$ while it slides. The paper integrates this by a Runge-Kutta method. Under
# samples with straight lines between them there is no need to: sticking and sliding are linear
# oscillators under linear loads, known in closed form, and only the instants at which one gives way
# to the other are roots that have to be found (`solver/reference/sliding.py`).

# +
import argparse
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from demos.program import output_of
from demos.study import Rows, is_first_rank, read_table
from demos.verdict import verdict
from solver.cli import main as rockslip
from solver.pictures.style import BLUE, ORANGE, legend_above, new_figure, save

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("suite")
PLATE, OUTPUT_OF_PLATE = HERE / "plate.toml", output_of("suite_plate")

FRICTIONS = (0.1, 0.2, 0.3, 0.4)

# -

# ## Running it
#
# One command does it all. It is the one of the command line,
#
#     rockslip study suite scene.toml --vary contact.friction=0.1,0.2,0.3,0.4 --reference \
#         --set time.largest=0.02
#
# and takes some minutes: 4000 to 6000 steps a run. `--resume` lets a second call do what is left
# after an interruption: every finished run is in a file of its own. Under `mpirun` the ranks share
# the work.


# +
def shake(words: list[str], output: Path = OUTPUT, scene: Path = SCENE) -> int:
    """Run the suite; returns its exit code."""
    vary = "contact.friction=" + ",".join(f"{friction:g}" for friction in FRICTIONS)
    again = [] if "--force" in words else ["--resume"]
    own_steps = any(word.startswith("time.") for word in words)
    steps = [] if own_steps else ["--set", "time.largest=0.02"]
    command = ["study", "suite", str(scene), "--vary", vary, "--reference", *steps, *again]
    return rockslip([*command, "-o", str(output), *words])


def column(rows: Rows, name: str, friction: float) -> np.ndarray:
    """A column of the completed runs with one friction coefficient."""
    chosen = [row for row in completed(rows) if float(row["contact.friction"]) == friction]
    return np.array([float(row[name]) for row in chosen])


def completed(rows: Rows) -> Rows:
    """The rows of the runs that reached their end and have a reference."""
    return [row for row in rows if row.get("platform.peak_drift_ratio")]


# -

# ## Picture
#
# Peak drift of the platform in every run, finite elements inside the reference, one panel for each
# friction coefficient; the motions are in the order of their drift with the most friction.


# +
DRIFT, EXACT = "platform.peak_drift_m", "reference.platform.peak_drift_m"
RATIO = "platform.peak_drift_ratio"


def picture(rows: Rows, folder: Path) -> Path:
    """Peak drifts of all runs; returns the file."""
    return save(lambda: _drawn(rows), folder / "peak_drifts.png")


def _drawn(rows: Rows) -> Figure:
    figure = new_figure(5.0)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    by_drift = sorted(
        (row for row in completed(rows) if float(row["contact.friction"]) == FRICTIONS[-1]),
        key=lambda row: float(row[EXACT]),
    )
    place = {row["motion"]: number for number, row in enumerate(by_drift, start=1)}
    for axes, friction in zip(panels.flat, FRICTIONS, strict=True):
        chosen = [
            row
            for row in completed(rows)
            if float(row["contact.friction"]) == friction and row["motion"] in place
        ]
        at = [place[row["motion"]] for row in chosen]
        ring = {"markersize": 7, "markerfacecolor": "none", "markeredgewidth": 1.6}
        exact = [1e3 * float(row[EXACT]) for row in chosen]
        axes.plot(at, exact, "o", color=ORANGE, label="rigid block, closed form", **ring)
        drift = [1e3 * float(row[DRIFT]) for row in chosen]
        axes.plot(at, drift, "o", color=BLUE, markersize=3, label="finite elements")
        mean = column(rows, RATIO, friction).mean()
        axes.set_title(f"friction {friction:g}: mean ratio {mean:.4f}", loc="left")
    for axes in panels[1]:
        axes.set_xlabel("motion")
    for axes in panels[:, 0]:
        axes.set(ylabel="peak drift (mm)", ylim=(0, None))
    legend_above(figure)
    return figure


# -

# ## Checks
#
# For each friction coefficient the mean of the ratios is 1 within 0.5 %, and every single ratio
# within 2 %. One that fails ends the demo with exit code 1.


# +
def checks(rows: Rows) -> list[tuple[bool, str]]:
    """Check the runs; a line for each check."""
    done = completed(rows)
    results = [(len(done) == len(rows), f"{len(done)} of {len(rows)} runs completed")]
    for friction in FRICTIONS:
        ratio = column(rows, RATIO, friction)
        if not len(ratio):
            results.append((False, f"friction {friction:g}: no run"))
            continue
        mean, least, most = ratio.mean(), ratio.min(), ratio.max()
        of = f"friction {friction:g}, {len(ratio)} motions"
        results += [
            (abs(mean - 1) <= 0.005, f"{of}: mean ratio {mean:.4f}, within 1.000 +- 0.005"),
            (
                max(most - 1, 1 - least) <= 0.02,
                f"{of}: every ratio {least:.4f} to {most:.4f}, within 1 +- 0.02",
            ),
        ]
    return results


def show(folder: Path) -> int:
    """Draw and check what stands in the folder of a suite; returns the exit code."""
    rows = read_table(folder / "suite.csv")
    results = checks(rows)
    if completed(rows):
        print(f"\n{picture(rows, folder)}\n")
    return verdict("platform_suite", results)


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code. Its options are those of `rockslip study suite`."""
    parser = argparse.ArgumentParser(description="The paper's platform under a suite of motions.")
    parser.add_argument("-o", "--output", type=Path, help="folder of the suite")
    parser.add_argument("--plate", action="store_true", help="on a meshed plate on rollers")
    options, words = parser.parse_known_args(arguments)
    scene, output = (PLATE, OUTPUT_OF_PLATE) if options.plate else (SCENE, OUTPUT)
    output = options.output or output
    code = shake(words, output, scene)
    if code not in (0, 3):  # 3: single runs failed, which the checks will say
        return code
    return show(output) if is_first_rank() else 0


if __name__ == "__main__":
    sys.exit(main())
# -
