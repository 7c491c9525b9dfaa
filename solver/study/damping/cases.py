"""The study of damping: impacts over parameters that are swept, and calibration of a parameter."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

import numpy as np
import tomli_w

from solver.errors import NotConverged, SceneError, Statement
from solver.run.streams import say
from solver.scene import parse_scene
from solver.study.damping import numbers
from solver.study.damping.axes import (
    ALLOWED,
    AXES,
    BaseScene,
    DampingCase,
    swept_values,
    time_for,
    watched,
)
from solver.study.damping.calibration import Search, Trial, target_of
from solver.study.damping.numbers import Restitution, restitution_of
from solver.study.scenes import scene_tables
from solver.study.study import CASES, Row, Study, numbers_by_name
from solver.study.tables import Column, in_words, write
from solver.types import Array

CLOSE = 4e-3
"""Difference from a restitution, or from peaks over that of the release, that is good enough."""


def run(options: argparse.Namespace) -> int:
    """Run the study, or with `--target` the calibration, of a command line; its exit code."""
    return (SweepStudy if options.target is None else Calibration).run(options)


class _Impacts(Study[DampingCase]):
    """Runs of one scene with other values of its parameters, whose impacts count.

    Attributes:
        base: What is varied.
    """

    kind, noun = "damping", "study of damping"
    same = "the same scene and block"
    files = ("calibration.*", "calibrated.toml")

    def __init__(self, options: argparse.Namespace):
        """Read the scene, and find the block whose impacts count."""
        super().__init__(options)
        if options.impacts < 1:
            raise SceneError("--impacts", f"{options.impacts}", "a whole number > 0")
        tables, path = scene_tables(options), options.scene
        scene = parse_scene(tables, folder=path.parent, source=path.name)
        block = watched(scene, options.block)
        if scene.motion is not None:  # with names of files that hold in every folder
            tables["motion"] = scene.to_dict()["motion"]
        end = time_for(scene, block, options.impacts)
        self.base = BaseScene(tables=tables, scene=scene, block=block, end=end)
        self.settings = {"scene": scene.to_dict(), "block": block.name}

    def keep(self, case: DampingCase, row: Row) -> Row:
        """Keep a case, its angle in a file of its own; returns its row."""
        row = dict(row)
        angle = row.pop("angle", None)
        if angle is not None:
            lines = ["time_s,angle_rad", *(f"{time:.6f},{value:.9g}" for time, value in angle)]
            write(self.folder / CASES / f"{case.key}.csv", "\n".join(lines) + "\n")
        return super().keep(case, row)


class SweepStudy(_Impacts):
    """Restitution over parameters, one at a time.

    Attributes:
        own: The case of the scene as it is.
        swept: The values of all axes, and their cases.
        left_out: Axes of which the scene takes not all default values, in words.
    """

    def __init__(self, options: argparse.Namespace):
        """Read the command line; refuse what the scene does not take."""
        super().__init__(options)
        self.own = self.base.case()
        self.swept, self.left_out = swept_values(self.base, options.of)
        self.wanted = [self.own, *(swept.case for swept in self.swept)]

    def write(self) -> str:
        """Write the tables and pictures of what has been done."""
        from solver.study.damping.picture import restitution_picture

        if not self.ordered:
            return ""
        rows, impacts = self.rows, self.options.impacts
        found = numbers.lines(self.swept, rows, impacts)
        own = restitution_of(rows.get(self.own.key), impacts)
        table = list(numbers.rows_of_table(self.own, self.swept, rows, impacts))
        told = list(numbers.remarks(table, found, self.left_out))
        title = self.base.scene.title or "Restitution of impacts"
        text = numbers.page(title, table, impacts, told)
        summary = {
            "block": self.base.block.name,
            "impacts": impacts,
            "scene": None if own is None else numbers.measures(own),
            "lines": [numbers.as_json(line) for line in found],
        }
        self.leave(table, text, summary, digits=8)
        if lines := [line for line in found if line.values]:
            self.draw("damping.png", restitution_picture, lines, own)
        return text

    def say(self, text: str) -> None:
        """Say what was found, what failed among it, and where it is."""
        say(f"{text}written to {self.folder}\n")


class Calibration(_Impacts):
    """The value of a parameter with which the impacts of a scene keep what was measured.

    Attributes:
        axis: The parameter.
        bounds: Its least and largest value.
        target: What runs are compared with.
        search: The runs so far.
    """

    table = "calibration"

    def __init__(self, options: argparse.Namespace):
        """Read the command line; refuse what the scene does not take."""
        super().__init__(options)
        able = [axis.name for axis in AXES.values() if axis.bounds is not None]
        (name, values), *others = numbers_by_name(
            "--of", options.of or able[:1], tuple(AXES), ALLOWED
        ).items()
        axis = AXES[name]
        if others or axis.bounds is None:
            allowed = f"{' or '.join(able)} with --target"
            raise SceneError("--of", " ".join(options.of), allowed)
        if values and not (len(values) == 2 and 0 < values[0] < values[1]):
            raise SceneError("--of", " ".join(options.of), f"{name}=LEAST,LARGEST, both > 0")
        base = self.base
        low, high = values or axis.bounds(base.scene, base.block)
        self.axis, self.bounds = axis, (low, high)
        self.target = target_of(options.target, base.scene, base.block, options.impacts)
        for value in self.bounds:
            base.case(axis, value)  # what the scene does not take is refused here
        self.search = Search(
            low=low, high=high, wanted=self.target.wanted, restitution=self.target.restitution
        )

    def rounds(self) -> Iterator[Sequence[DampingCase]]:
        """Runs at the values of the search, round after round.

        Raises:
            SceneError: The target is out of reach.
        """
        while values := self.search.next_values():
            cases = [self.base.case(self.axis, value) for value in values]
            yield cases
            for value, case in zip(values, cases, strict=True):
                self.search.tell(self._trial(value, self.rows.get(case.key)))
        if not self.search.within_reach:
            raise SceneError("--target", f"{self.target.restitution:.4g}", self._reach())

    def _trial(self, value: float, row: Row | None) -> Trial:
        """The trial of a row; refused where it has too few impacts."""
        where = f"{self.axis.name} {value:g}"
        if row is None or row["status"] != "completed":
            raise NotConverged(f"{where}: {'interrupted' if row is None else row['reason']}")
        known, found = Restitution.of(row, self.target.impacts), self.target.of(row)
        if found is None or known.mean is None:
            missing = known.too_few(row["end_s"]) or "too few peaks"
            raise Statement("--target", f"is out of reach: {where} has {missing}")
        return Trial(value=value, restitution=known.mean, found=found)

    @property
    def _best(self) -> Trial | None:
        """The run nearest to the target, where that is within reach."""
        search = self.search
        return search.best if search.made and search.within_reach else None

    @property
    def good(self) -> bool:
        """True if a run comes near enough."""
        return self._best is not None and self.search.best_error <= CLOSE

    def _reach(self) -> str:
        """The restitutions that can be reached, in words."""
        (least, largest), (low, high) = self.search.reach, self.bounds
        return f"{least:.4f} to {largest:.4f}, the reach of {self.axis.name} {low:g} to {high:g}"

    def write(self) -> str:
        """Write table, picture, summary and, where the target is within reach, the scene."""
        from solver.study.damping.picture import calibration_picture

        search, target, best = self.search, self.target, self._best
        if not search.made:
            return ""
        table = [
            {
                self.axis.name: trial.value,
                "restitution": trial.restitution,
                "difference": search.error(trial),
                **{f"peak_{k}": e for k, e in enumerate(trial.found, start=1) if target.peaks},
            }
            for trial in search.trials
        ]
        title = self.base.scene.title or "Calibration"
        text = numbers.markdown(title, self._cells(), self._sentences())
        summary = {
            "parameter": self.axis.name,
            "key": self.axis.key,
            "unit": self.axis.unit,
            "target_restitution": target.restitution,
            "target_peaks": list(target.peaks),
            "reach": list(search.reach),
            "runs": len(search.trials),
            "value": best.value if best else None,
            "restitution": best.restitution if best else None,
            "difference": search.best_error if best else None,
        }
        self.leave(table, text, summary, digits=8)
        angle = None
        if best is not None:
            calibrated = self.base.with_value(self.axis, best.value)
            write(self.folder / "calibrated.toml", tomli_w.dumps(calibrated))
            angle = self._kept_angle(self.base.case(self.axis, best.value).key)
        self.draw("calibration.png", calibration_picture, search, target, self.axis.label, angle)
        return text

    def _cells(self) -> list[list[str]]:
        """The table in words, the heading first."""
        difference = "difference of peaks" if self.target.peaks else "difference"
        columns = [
            *(Column("value", self.axis.label), Column("restitution", "restitution", ".4f")),
            Column("error", difference, ".4f"),
        ]
        rows = [
            {
                "value": f"{trial.value:g}{' *' if trial is self._best else ''}",
                "restitution": trial.restitution,
                "error": self.search.error(trial),
            }
            for trial in self.search.made
        ]
        return in_words(rows, columns)

    def _kept_angle(self, key: str) -> tuple[Array, Array]:
        """Times (s) and angles (rad) of a case."""
        file = self.folder / CASES / f"{key}.csv"
        found = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
        return found[:, 0], found[:, 1]

    def _sentences(self) -> list[str]:
        """The result in words."""
        target, best = self.target, self._best
        kind = "of the measured peaks" if target.peaks else f"of the first {target.impacts}"
        wanted = f"target: restitution {target.restitution:.4f}, the geometric mean {kind}"
        reach = f"within reach: {self._reach()}"
        if best is None:
            return [f"{wanted}; not {reach}"]
        unit = f" {self.axis.unit}" if self.axis.unit else ""
        found = f"{self.axis.key} = {best.value:g}{unit}: restitution {best.restitution:.4f}"
        found += f", after {len(self.search.trials)} runs"
        if self.good:
            return [wanted, reach, found]
        far = f"no run came nearer than {self.search.best_error:.4f}: impacts scatter"
        return [wanted, reach, found, far]

    def say(self, text: str) -> None:
        """Say the result, and where it is; a target out of reach is an error of its own."""
        if self._best is not None:
            say(f"{text}written to {self.folder}; run {self.folder / 'calibrated.toml'}\n")
