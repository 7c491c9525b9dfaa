"""Contact and friction."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from solver.errors import SceneError, missing_key
from solver.scene.checking import OPEN, Checked, is_open, shown
from solver.scene.quantities import Bedding, Cohesion, NotNegative, Number, Rate


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionSpec(Checked):
    """The paper's law of friction, tau = c + mu p: a table of the scene and the law of the engines.

    mu = mu_d [1 + (mu_s/mu_d - 1) exp(-DC v_rel)]; with DC = 0 a jump from mu_s to mu_d.
    `solver.law.friction` has the bounds of points by it.
    """

    static: NotNegative
    """mu_s."""
    dynamic: NotNegative = OPEN
    """mu_d, no larger than `static`. Default: that of `static`."""
    decay: Rate = 0.0
    """DC, s/m; 0 is a jump, which the paper says should be avoided: elastic blocks then break loose
    point by point and slip far less than rigid ones. Only where mu_d < mu_s."""
    cohesion: Cohesion = 0.0
    """c, Pa, over the area of the closed points."""
    cohesion_lost: bool = False
    """True: a point that has slipped has lost its cohesion. Only with cohesion."""

    def resolved(self) -> Iterator[tuple[str, Any]]:
        """mu_d, where it is that of `static`."""
        if is_open(self.dynamic):
            yield "dynamic", self.static

    def check(self) -> None:
        """Refuse values that do not go together."""
        if self.dynamic > self.static:
            raise SceneError("dynamic", shown(self.dynamic), f"dynamic <= static = {self.static:g}")
        if self.decay > 0 and self.dynamic == self.static:
            raise SceneError("decay", shown(self.decay), "0 where dynamic = static")
        if self.cohesion_lost and self.cohesion == 0:
            raise SceneError("cohesion_lost", "true", "false where cohesion = 0")

    @classmethod
    def of(cls, friction: float | FrictionSpec) -> FrictionSpec:
        """A number as the table that means the same; a table as it is."""
        return friction if isinstance(friction, FrictionSpec) else cls(static=friction)

    @property
    def constant(self) -> bool:
        """True if the bound depends on the pressure alone: neither on speed nor on the past."""
        return self.static == self.dynamic and self.cohesion == 0.0

    @property
    def decays(self) -> bool:
        """True if the coefficient depends on the speed of sliding."""
        return self.decay > 0

    @property
    def jumps(self) -> bool:
        """True if a point that breaks loose falls to less friction at once."""
        return (self.static != self.dynamic and not self.decays) or self.cohesion_lost

    def words(self) -> str:
        """The law in words."""
        words = [f"{self.static:g}"]
        if self.dynamic != self.static:
            fall = f"decaying with {self.decay:g} s/m" if self.decays else "a jump"
            words = [f"{self.static:g} static, {self.dynamic:g} dynamic, {fall}"]
        if self.cohesion:
            words.append(f"cohesion {self.cohesion:g} Pa{', lost by slip' * self.cohesion_lost}")
        return ", ".join(words)


@dataclass(frozen=True, slots=True)
class Bed:
    """A bed of springs and dashpots under a block (Winkler's).

    Attributes:
        stiffness: k over the area, Pa/m.
        retardation: Dashpot over spring, s.
        landing: Time of contact of a block that lands flat, half a period without damping, s.
    """

    stiffness: float
    retardation: float
    landing: float

    @classmethod
    def damped(cls, stiffness: float, ratio: float, mass: float) -> Bed:
        """The bed that damps a mass on it by a ratio of critical.

        Args:
            stiffness: k, Pa/m.
            ratio: Dashpot over 2 sqrt(k m).
            mass: m of the block over its bottom, kg/m2.
        """
        time = math.sqrt(mass / stiffness)
        return cls(stiffness, 2 * ratio * time, math.pi * time)


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactSpec(Checked):
    """Contact: `[contact]`."""

    points: Literal["nodes", "gauss"] = "nodes"
    """Contact points: at the nodes (Gauss-Lobatto), for rocking, where a block pivots about its
    very corner; or Gauss points, for sliding."""
    gamma: Annotated[float, Number(at_least=10)] = 100.0
    """Nitsche parameter, without dimension; the stiffness is gamma (lambda + 2 mu) degree²/h.
    [Smaller ones](stability.md#what-is-refused) are not stable."""
    theta: Literal[1, 0, -1] = 1
    """Nitsche variant: symmetric, which has an energy; fewest terms; skew."""
    friction: NotNegative | FrictionSpec = 0.6
    """For blocks that do not have their own; see [friction](#friction)."""
    stiffness: Bedding | None = None
    """k of a [bed of springs](#bed) between each block and what carries it, Pa/m. Meshed scenes
    only. Default: no bed; with `damping` a tenth of the block's own, 0.1
    (lambda + 2 mu)/H."""
    damping: Annotated[float, Number(at_least=0, at_most=1)] = 0.0
    """Dashpots of that bed, which never pull, over the critical value of a block on it. Meshed
    scenes only."""
    velocity_solve: bool = True
    """Solve contact once more for the velocities after each step; `false` for comparison."""

    @property
    def has_bed(self) -> bool:
        """True if blocks stand on a bed."""
        return self.stiffness is not None or self.damping > 0


@dataclass(frozen=True, slots=True, kw_only=True)
class PairSpec(Checked):
    """The contact of two bodies, where it differs from what is said of blocks: `[[pair]]`."""

    between: tuple[str, str]
    """Names of two blocks, or of one and `"foundation"`, in any order."""
    friction: NotNegative | FrictionSpec | None = None
    """Between these two; see [friction](#friction). Default: as without this table."""
    restitution: Annotated[float, Number(at_least=0, at_most=1)] | None = None
    """e of impacts of these two; see [restitution](#restitution). Where nothing is meshed only.
    Default: as without this table."""

    def check(self) -> None:
        """Refuse a pair of one body, and a table that says nothing."""
        if len(set(self.between)) == 1:
            raise SceneError("between", shown(self.between), "two different names")
        if self.friction is None and self.restitution is None:
            raise missing_key("friction", "where restitution is not given")

    @property
    def where(self) -> str:
        """The path of its table."""
        return ".".join(("pair", *self.between))
