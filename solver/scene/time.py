"""Time stepping: the table `[time]`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from solver.errors import SceneError, not_applicable
from solver.scene.checking import Checked, Number, shown
from solver.scene.ranges import NotNegative, Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeSpec(Checked):
    """Time stepping: `[time]`."""

    end: Positive
    """Time at which the run ends, s."""
    step: Positive
    """dt, s; no longer than `end`. What it decides: [small steps](method.md#small-steps)."""
    rho_inf: Annotated[float, Number(at_least=0, at_most=1)] = 0.8
    """Spectral radius that the weights of generalized-alpha come from; smaller ones damp more of
    the vibration of the blocks."""
    damped_steps: Annotated[int, Number(at_least=0)] = 8
    """Steps after a change of contact (open, stick, slip) that are taken with `rho_inf` = 0, which
    takes out vibration that the step does not resolve; 0 for none, as with `rho_inf = 1`. All
    bodies of a scene together; without effect where nothing is meshed."""
    initial: Literal["static", "unstressed"] = "static"
    """Begin in equilibrium with gravity, where no block is tilted; or without stress."""
    smallest: NotNegative = 0.0
    """Smallest step to which steps that do not converge are halved, s; 0 becomes step/1024."""
    adaptive: bool = False
    """Whether steps are chosen by their error: `step`, with which the run begins, times powers of
    two. Not where nothing is meshed: there steps are cut at events anyway."""
    tolerance: Positive | None = None
    """Error of a step in the motion of a body, over half its diagonal, around events; ten times
    that elsewhere. Adaptive only. Default: adaptive: `1e-7`."""
    largest: Positive | None = None
    """Longest step, s. Adaptive only. Default: adaptive: 4 `step`."""

    def __post_init__(self) -> None:
        """Check the values."""
        Checked.__post_init__(self)
        for key in ("tolerance", "largest"):
            if getattr(self, key) is not None and not self.adaptive:
                raise not_applicable(key, "adaptive steps only (adaptive = true)")
        if self.adaptive and self.tolerance is None:
            object.__setattr__(self, "tolerance", 1e-7)
        if self.adaptive and self.largest is None:
            object.__setattr__(self, "largest", 4 * self.step)
        if self.largest is not None and self.largest < self.step:
            raise SceneError("largest", shown(self.largest), f"largest >= step = {self.step:g}")
        if self.step > self.end:
            raise SceneError("step", shown(self.step), f"step <= end = {self.end:g}")
        if self.smallest > self.step:
            raise SceneError("smallest", shown(self.smallest), f"smallest <= step = {self.step:g}")
        if self.smallest == 0:
            object.__setattr__(self, "smallest", self.step / 1024)
