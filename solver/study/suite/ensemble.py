"""An ensemble: the motions of a suite at several levels of intensity, by several engines."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from solver.errors import SceneError, missing_key
from solver.scene.checking import shown
from solver.study.suite.engines import ELASTIC, ENGINES, ODE, with_model
from solver.study.suite.intensity import ROTD50, Intensity


@dataclass(frozen=True, slots=True)
class EnsemblePart:
    """Engine and level of a case; None: the scene, or the motion, as it is."""

    engine: str | None = None
    level: float | None = None
    intensity: Intensity | None = None

    def columns(self) -> dict[str, Any]:
        """What a row says of it."""
        found = {"engine": self.engine, "level": self.level}
        return {key: value for key, value in found.items() if value is not None}


@dataclass(frozen=True, slots=True)
class Ensemble:
    """Engines and levels of a suite."""

    engines: tuple[str, ...] = ()
    levels: tuple[float, ...] = ()
    intensity: Intensity | None = None

    @property
    def is_one(self) -> bool:
        """Whether there is anything to draw statistics from: levels, or engines side by side."""
        return bool(self.engines or self.levels)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns in which its cases differ."""
        return tuple(next(self.parts()).columns())

    def notes(self, beside: Collection[str]) -> list[str]:
        """How its levels are meant, and when its runs end."""
        if self.intensity is None:
            return []
        of = "" if self.intensity.horizontal else " along x"
        factor = "; all components of an event have one factor" if beside else ""
        ends = "runs end before their motions do once a block has overturned"
        return [f"levels are of {self.axis}{of}{factor}", ends]

    @property
    def axis(self) -> str:
        """The measure with its unit."""
        return f"{self.intensity.name} ({self.intensity.unit})" if self.intensity else ""

    def parts(self) -> Iterator[EnsemblePart]:
        """Every engine at every level."""
        for engine in self.engines or (None,):
            for level in self.levels or (None,):
                yield EnsemblePart(engine, level, self.intensity)

    def settings(self) -> dict[str, Any]:
        """What a suite that is resumed must have in common with the earlier one."""
        measure = self.intensity.name if self.intensity else None
        return {"engines": self.engines, "levels": self.levels, "intensity": measure}


def read_ensemble(
    options: argparse.Namespace, tables: Mapping[str, Any], folder: Path, beside: Collection[str]
) -> Ensemble:
    """The ensemble of a command line; tables and folder are those of the scene, without motion.

    `beside` holds the keys of the components that its motions have besides that along x.

    Raises:
        SceneError: An option is none, or the scene is not one for an engine.
    """
    from solver.scene import parse_scene
    from solver.study.standing import numbers, refuse_components, refuse_others, words

    for option in ("intensity", "horizontal"):
        if getattr(options, option) and not options.levels:
            raise missing_key("--levels", f"beside --{option}")
    if options.horizontal and "second" not in beside:
        allowed = "it for a scene with [motion.second]"
        raise SceneError("--horizontal", options.horizontal, allowed)
    engines = tuple(words("--engines", options.engines, ENGINES)) if options.engines else ()
    for engine in engines:
        scene = parse_scene(with_model(tables, engine), folder=folder)
        if engine == ODE:
            refuse_others(scene)
            refuse_components(beside)
            if options.reference:
                got = shown(options.engines)
                raise SceneError("--engines", got, f"{ENGINES[0]}, {ELASTIC} beside --reference")
    if not options.levels:
        return Ensemble(engines)
    levels = tuple(sorted(numbers("--levels", options.levels)))
    intensity = Intensity.read(options.intensity or "PGA")
    if "second" in beside:
        intensity = replace(intensity, horizontal=options.horizontal or ROTD50)
    return Ensemble(engines, levels, intensity)
