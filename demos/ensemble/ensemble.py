# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # How likely a block falls
#
# Two histories of rocking that differ in their last digits part after a while, and no program
# agrees with another one, or with a test, about a block in an earthquake. What can be compared is
# what many earthquakes do: distributions of peaks, and probabilities of overturning.
#
# This demo illustrates how to:
#
# - scale many motions to levels of intensity,
# - run them with rigid blocks, with elastic ones, and by Housner's equation, beside each other,
# - compare distributions, and draw a fragility curve through what overturned.
#
# ## Fragility
#
# Let $x$ be an intensity, such as the peak acceleration of the ground (PGA). Of $n$ motions that
# are scaled to $x$, $k$ overturn the block. The lognormal curve
#
# $$ P(x) = \Phi\!\left(\frac{\ln(x/x_m)}{\beta}\right) $$
#
# has two parameters: the median $x_m$, and $\beta$, which says how much motions of one intensity
# differ. Those of largest likelihood
#
# $$ \prod_i P(x_i)^{k_i}\,[1 - P(x_i)]^{n_i - k_i} $$
#
# are found, and the intervals that so few motions leave them.

# +
import json
import sys
from pathlib import Path

from demos.program import output_of
from demos.study import judged_study, read_table

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("ensemble")
# -

# ## Running it
#
# One command does it all:
#
#     rockslip study suite scene.toml --count 100 --levels 0.3:0.7:5 --engines rigid,ode
#
# The elastic block takes longer, up to a minute for each motion: `--engines rigid,ode,elastic`. A
# study that was interrupted goes on where it was.

# +
COMMAND = ["suite", str(SCENE), "--levels", "0.3:0.7:5", "--engines", "rigid,ode"]
# -

# ## Checks
#
# Where no block overturns, and where all do, engines agree exactly. In between, samples of $n$
# motions differ by chance; two samples of one distribution are farther apart than
# $1.63\sqrt{2/n}$ once in a hundred times (Kolmogorov and Smirnov).


# +
def checks(folder: Path) -> list[tuple[bool, str]]:
    """Check that the engines agree, as far as samples of this size can."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    done = f"{summary['completed']} of {summary['cases']} cases completed"
    results = [(summary["completed"] == summary["cases"], done)]
    count = min(int(row["motions"]) for row in read_table(folder / "fragility.csv"))
    most = 1.63 * (2 / count) ** 0.5
    for apart in summary["distances"]:
        names = " and ".join(apart["engines"])
        text = f"{names} at {apart['level']:g} g: distance {apart['angle']:.3f}, at most {most:.3f}"
        results.append((apart["angle"] <= most, text))
    return results


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code. Its options are those of `rockslip study suite`."""
    return judged_study(COMMAND, checks, arguments, output=OUTPUT)


if __name__ == "__main__":
    sys.exit(main())
# -
