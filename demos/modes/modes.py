# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: light
# ---

# # How a block begins to move
#
# A block at rest is hit by a sudden acceleration of its base. Does it stay, slide, rock, or slide
# and rock at once? Shenton (1996) answered this for a rigid block; the paper shows his map as its
# Figure 2. Here the program finds the map by itself, with rigid blocks and with elastic ones.
#
# This demo illustrates how to:
#
# - tell modes by the first accelerations of a run, not by how it ends,
# - run a grid of frictions and accelerations on all processors,
# - compare with closed forms, and with what an elastic block can be compared with.
#
# ## The criteria
#
# Let $r = H/B$ and $A = a_g/g$. Static and dynamic friction are the same, $\mu$. The block
#
# - rests where $A \le \min(\mu, 1/r)$,
# - slides where $\mu < 1/r$ and $A > \mu$,
# - rocks where $A > 1/r$ and $\mu \ge \mu_R(A) = [A (4 + r^2) + 3 r] / [1 + 4 r^2 + 3 r A]$,
# - slides and rocks in between, where $A > 1/r$ and $1/r < \mu < \mu_R(A)$.
#
# With half width $b$ and half height $h$ it begins with
#
# $$ \ddot\theta = \tfrac34 \frac{a h - g b}{b^2 + h^2} \quad\text{(rock)}, \qquad
#    \ddot\theta = \frac{3 g (\mu r - 1)}{b (4 + r^2 - 3 \mu r)} \quad\text{(slide-rock)}, $$
#
# and its corner slips with $\ddot s = a - h\ddot\theta - \mu (g + b\ddot\theta)$ where it slides.
# A block that slides and rocks turns as fast whatever the acceleration is.
#
# ## Two ways to look
#
# A rigid block takes the acceleration at once, and its first 20 ms tell both numbers. An elastic
# block would overshoot. Its base therefore takes 30 ms to reach the acceleration, and what counts
# is the time from 40 to 80 ms. By then the block has turned a little, so that its accelerations
# are no longer the first ones. A rigid block under the same ramp has turned by as much, and stands
# beside it in the table. Larger blocks turn more slowly: these times go with $1/p$.

# +
import json
import sys
from pathlib import Path

from demos.program import output_of
from demos.study import judged_study

HERE = Path(__file__).resolve().parent
SCENE, OUTPUT = HERE / "scene.toml", output_of("modes")
# -

# ## Running it
#
# One command does it all:
#
#     rockslip study modes scene.toml --ratios 4
#
# Points whose mode changes with a change of $\mu$ and $A$ by 3 % are drawn, but not judged. A
# study that was interrupted goes on where it was.

# +
COMMAND = ["modes", str(SCENE)]
# -

# ## Checks
#
# All judged points agree with the criteria. Rigid blocks meet the closed forms within 0.1 %.
# Elastic ones are within 2 % of the rigid block under the same ramp.


# +
def checks(folder: Path) -> list[tuple[bool, str]]:
    """Check the maps; a line for each check."""
    results = []
    for found in json.loads((folder / "summary.json").read_text(encoding="utf-8"))["maps"]:
        name = f"{found['engine']} block, H/B = {found['ratio']:g}"
        agree = f"{found['agree']} of {found['judged']} judged points agree"
        results.append((found["agree"] == found["judged"] > 0, f"{name}: {agree}"))
        what, most = ("expected", 1e-3) if found["engine"] == "rigid" else ("rigid", 2e-2)
        keys = ("slide_slip", "rock_turn", "slide_rock_turn")
        errors = [e for key in keys if (e := found[f"{what}_{key}"]) is not None]
        worst = max(errors, default=0.0)
        beside = "closed forms" if what == "expected" else "a rigid block under the same ramp"
        text = f"{name}: within {100 * worst:.3f} % of {beside}, at most {100 * most:g} %"
        results.append((worst <= most, text))
    return results


def main(arguments: list[str] | None = None) -> int:
    """The demo; returns its exit code. Its options are those of `rockslip study modes`."""
    return judged_study(COMMAND, checks, arguments, output=OUTPUT)


if __name__ == "__main__":
    sys.exit(main())
# -
