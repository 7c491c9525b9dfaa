"""Time stepping: the table `[time]`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from solver.errors import SceneError
from solver.scene.checking import OPEN, Checked, is_open, only_where, shown
from solver.scene.quantities import Delay, Duration, Number, Positive

LONGEST_STEP = 0.04
"""Longest adaptive step over the time scale of rocking, 1/p."""
STEP_OF_RIGID_SCENES = 1e-3
"""Step of scenes in which nothing is meshed, over the time scale of rocking."""
LARGEST_TURN = 0.01
"""Largest angle by which rigid blocks in space, which turn by 2 arctan(w dt/2) in a step, turn in
the first step of a scene without `time.step`, rad: what they turn by is wrong by 8e-6 of it."""
STEPS_A_PERIOD = 20
"""Fewest steps in the shortest period of the ground's motion, and of the bodies on a link: there
the largest force of a tether that snaps taut was off by 0.1 to 0.4 %, energy by round-off."""
MOST_FOR_LINKS = 10
"""How many times as many steps a run without `time.step` takes at most for its links: what swings
faster acts by its means."""
FEWEST_STEPS = 100
"""Fewest steps in which a run without `time.step` reaches its end."""
MOST_STEPS = 1e8
"""Largest number of steps of a run, whose history is kept in memory."""
TOLERANCE = 1e-3
"""Tolerance of adaptive steps."""
DAMPED_STEPS = 8
"""Damped steps after a change of contact where steps are fixed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeSpec(Checked):
    """Time stepping: `[time]`."""

    end: Duration
    """Time at which the run ends, s."""
    step: Duration = OPEN
    """dt of fixed steps, s; no longer than `end`. Its effect:
    [small steps](method.md#small-steps). Default: none: steps are adaptive and resolve each impact,
    and `step` becomes a quarter of `largest`; where nothing is meshed, a thousandth of 1/p, in 3-D
    no longer than what a block turns by 0.01 rad in as it starts; with links a twentieth
    of the period on the stiffest one, down to a tenth of what it is without them."""
    stop: Literal["end", "overturned"] = "end"
    """The end of the run: at `end`, or once a block
    [has overturned](output.md#when-a-run-ends-early)."""
    rho_inf: Annotated[float, Number(at_least=0, at_most=1)] = 0.8
    """Spectral radius that the weights of generalized-alpha come from; smaller ones damp more of
    the vibration of the blocks."""
    damped_steps: Annotated[int, Number(at_least=0)] = OPEN
    """For how many times `step` after a change of contact (open, stick, slip) the scheme takes
    `rho_inf` = 0, which takes out vibration that fixed steps do not resolve; 0 for none, as with
    `rho_inf = 1`. All bodies of a scene together; without effect where nothing is meshed. Default:
    8; adaptive: 0, as these steps resolve what vibrates."""
    initial: Literal["static", "unstressed"] = "static"
    """Begin in equilibrium with gravity, where no block is tilted or begins in the air; or without
    stress."""
    smallest: Delay = 0.0
    """Smallest step to which steps that do not converge, or are not accurate enough, are halved, s;
    0 becomes step/1024, with adaptive steps step/16384."""
    adaptive: bool = False
    """True: steps are chosen by their error: `step`, with which the run begins, times powers of
    two; always so in meshed scenes without `step`. Not where nothing is meshed: there steps are cut
    at events anyway."""
    tolerance: Positive | None = None
    """About the error of the restitution of an impact. Adaptive only. Default: adaptive: `1e-3`."""
    largest: Duration | None = None
    """Longest step, s. Adaptive only. Default: adaptive: 4 `step`; without `step` 0.04/p of the
    block that rocks fastest, p = sqrt(3 g/(4 R)), at most a hundredth of `end` and a twentieth of
    the shortest period of the ground's motion. It is shortened where a body is too stiff for it."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """The values that follow from `step`; without it the scene has them (`in_scene`)."""
        if is_open(self.step):
            return
        if self.adaptive and self.tolerance is None:
            yield "tolerance", TOLERANCE
        if self.adaptive and self.largest is None:
            yield "largest", 4 * self.step
        if self.smallest == 0:
            yield "smallest", self.step / (16384 if self.adaptive else 1024)
        if is_open(self.damped_steps):
            yield "damped_steps", 0 if self.adaptive else DAMPED_STEPS

    def check(self) -> None:
        """Refuse values that do not go together."""
        if is_open(self.step):
            return
        what = "adaptive steps only (adaptive = true)"
        only_where(self, self.adaptive, what, "tolerance", "largest")
        if self.largest is not None and self.largest < self.step:
            raise SceneError("largest", shown(self.largest), f"largest >= step = {self.step:g}")
        if self.step > self.end:
            raise SceneError("step", shown(self.step), f"step <= end = {self.end:g}")
        if self.end > self.step * MOST_STEPS:
            least = f"step >= {self.end / MOST_STEPS:g}, {MOST_STEPS:g} steps to the end"
            raise SceneError("step", shown(self.step), f"{least}: they fill 30 GB of memory")
        if self.smallest > self.step:
            raise SceneError("smallest", shown(self.smallest), f"smallest <= step = {self.step:g}")

    def in_scene(
        self,
        *,
        is_rigid: bool,
        frequency: float,
        spin: float,
        period: float,
        links: float,
        stiffest: float,
    ) -> TimeSpec:
        """Time stepping in a scene with or without a mesh, nothing left open.

        The frequency is p of the block that rocks fastest, 1/s, 0 without gravity; `spin` how fast
        a rigid one turns in space at the start, rad/s; the period the shortest of the ground's
        motion, s; `links` that of the bodies of a link, s; `stiffest` the longest step that the
        stiffest meshed body allows, s.
        """
        if not is_open(self.step):
            if self.largest is not None and self.step <= stiffest < self.largest:
                return replace(self, largest=max(rounded_down(stiffest), self.step))
            return self
        longest = min(self.end / FEWEST_STEPS, period / STEPS_A_PERIOD)
        if frequency > 0:
            share = STEP_OF_RIGID_SCENES if is_rigid else LONGEST_STEP
            longest = min(longest, share / frequency)
        longest = max(min(longest, links / STEPS_A_PERIOD), longest / MOST_FOR_LINKS)
        if is_rigid:
            if spin > 0.0:
                longest = min(longest, LARGEST_TURN / spin)
            return replace(self, step=self._whole(rounded_down(longest)))
        if self.largest is not None:
            longest = self.largest
        elif longest < stiffest:
            longest = rounded_down(longest)
        longest = self._whole(min(longest, stiffest))
        return replace(self, step=longest / 4, largest=longest, adaptive=True)

    def _whole(self, longest: float) -> float:
        """The longest step not above this one (s) of which a whole number reaches the end."""
        steps = math.ceil(self.end / longest * (1 - 1e-12))
        return float(f"{self.end / steps:.12g}")


def rounded_down(step: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a step."""
    power = 10.0 ** math.floor(math.log10(step) + 1e-9)
    digit = next(digit for digit in (5, 2, 1) if digit * power <= step * (1 + 1e-9))
    return float(f"{digit * power:.0e}")
