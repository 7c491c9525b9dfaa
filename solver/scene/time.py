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
    """s."""
    step: Positive
    """dt, s."""
    rho_inf: Annotated[float, Number(at_least=0, at_most=1)] = 0.8
    """Spectral radius of generalized-alpha at infinity."""
    damped_steps: Annotated[int, Number(at_least=0)] = 8
    """Steps after a change of contact that are taken with rho_inf = 0; none where it is 1."""
    initial: Literal["static", "unstressed"] = "static"
    """Begin with gravity in equilibrium (blocks that begin closed), or without stress."""
    smallest: NotNegative = 0.0
    """Smallest step to which steps that do not converge are halved, s; 0 becomes step / 1024."""
    adaptive: bool = False
    """Whether steps are chosen by their error, `step` times powers of two; `step` is the first."""
    tolerance: Positive | None = None
    """Adaptive only: error of a step around events, over the half diagonal; None becomes 1e-7."""
    largest: Positive | None = None
    """Adaptive only: longest step, s; None becomes 4 `step`."""

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
