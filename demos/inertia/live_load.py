# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # How much of the live load counts as inertia
#
# A deck on piles carries goods that are not fixed to it. In an earthquake they stick, slide, stop
# and slide again. Who designs the piles has to choose a mass: that of the deck and which portion
# of the goods? The paper defines it (section 6): the portion $\lambda$ that, fixed to a linear
# structure of the same stiffness, gives the same mean peak drift over a suite of motions.
#
# This demo illustrates how to:
#
# - map $\lambda$ over the period of the structure and the friction under the goods,
# - read its interval, its roots, and the base shear's own ratio,
# - compare the block that slides with the engine of rigid blocks.
#
# ## Definition
#
# The block of mass $m_L$ slides on the structure of mass $m_P$, spring $k$ and dashpot $c$. The
# linear structure keeps $k$ and $c$ and has the mass $m_P + \lambda m_L$; $D(\lambda)$ is the mean
# of its peak drifts over the motions. $\lambda$ solves
#
# $$ D(\lambda) = \frac{1}{n} \sum_{i=1}^{n} \max_t |u_i(t)| $$
#
# where $u_i$ is the drift under the block that slides. There can be several roots, or none. With
# infinite friction nothing slides and $\lambda = 1$; the root that is reported is followed from
# there as friction goes down. `docs/inertia.md` has the details.

# +
import argparse
import sys
from pathlib import Path

from demos.program import output_of
from demos.study import Rows, is_first_rank, read_table
from demos.verdict import verdict
from solver.cli import main as rockslip

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("inertia")

MAP = ("period=0.25,0.5,1,2", "friction=0.05,0.1,0.2,0.4")
BLOCKS = ("friction=0.1,0.2,0.3",)

# -

# ## Running it
#
# Two studies: the map by a sliding block with 300 synthetic motions, and one line of it by rigid
# blocks with 30 motions. Both go on where they were stopped. Each leaves tables and pictures, which
# `rockslip report` puts on one page.


# +
def study(name: str, words: list[str], output: Path = OUTPUT) -> int:
    """Run a study in a folder of this name; returns its exit code."""
    again = [] if "--force" in words else ["--resume"]
    command = ["study", "inertia", str(SCENE), "-o", str(output / name), *again]
    output.mkdir(parents=True, exist_ok=True)
    return rockslip([*command, *words])


# -

# ## Checks
#
# With more friction more of the live load counts: no value lies below the interval of the one
# before. Rigid blocks agree with the sliding block within 0.003. A check that fails ends the demo
# with exit code 1.


# +
def checks(of_map: Rows, of_blocks: Rows) -> list[tuple[bool, str]]:
    """Check the studies; a line for each check."""
    results = []
    for period in dict.fromkeys(row["period_s"] for row in of_map):
        rows = [row for row in of_map if row["period_s"] == period]
        values, lows = ([float(row[key]) for row in rows] for key in ("lambda", "lambda_low"))
        grows = all(low <= value for low, value in zip(lows, values[1:], strict=False))
        said = ", ".join(f"{value:.3f}" for value in values)
        results.append((grows, f"T {period} s: {said}, growing within the intervals"))
    slides = {row["friction"]: row for row in of_blocks if row["by"] == "sliding block"}
    for row in of_blocks:
        if row["by"] != "sliding block":
            other = slides[row["friction"]]
            one, two = float(row["lambda"]), float(other["lambda"])
            text = f"friction {row['friction']}: {one:.4f} by rigid blocks, {two:.4f} by the "
            text += "sliding block"
            results.append((abs(one - two) <= 0.003, text))
    return results


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code. Its options are those of `rockslip study inertia`."""
    parser = argparse.ArgumentParser(description="How much of the live load counts as inertia.")
    parser.add_argument("-o", "--output", type=Path, default=OUTPUT, help="folder of the studies")
    parser.add_argument("--count", type=int, help="motions; default 300 for the map, 30 for blocks")
    options, words = parser.parse_known_args(arguments)
    counts = [options.count or count for count in (300, 30)]
    output = options.output
    code = study("map", ["--of", *MAP, "--count", f"{counts[0]}", *words], output)
    if code == 0:
        more = ["--of", *BLOCKS, "--by", "rigid", "--count", f"{counts[1]}", *words]
        code = study("blocks", more, output)
    if code or not is_first_rank():
        return code
    print(f"\n{output / 'map' / 'lambda.png'}\n")
    tables = (read_table(output / name / "inertia.csv") for name in ("map", "blocks"))
    return verdict("live_load", checks(*tables))


if __name__ == "__main__":
    sys.exit(main())
# -
