"""The command `rockslip study NAME ...`: what each study does, and its options.

The studies themselves are imported when they run: heavy imports stand there. Those that measure the
program itself stand in `benchmarks/` of the repository.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from pkgutil import resolve_name

from solver.arguments import add_overrides, add_scene
from solver.errors import Statement

AXES = "period, friction or friction_over_pga, mass_ratio, damping_ratio, aspect"
PULSES, FREQUENCIES, AMPLITUDES = "half_sine,one_sine", "0.5:10:40", "1:12:48"


def add_studies(parser: argparse.ArgumentParser) -> None:
    """Add a command for each study."""
    names = parser.add_subparsers(dest="study", metavar="NAME", required=True)
    for name, (text, add_options, _) in STUDIES.items():
        added = names.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        add_options(added)
        added.set_defaults(action=run_study, repeated=f"rockslip study {name}")


def run_study(options: argparse.Namespace) -> int:
    """Run the study that the options name; returns its exit code.

    Raises:
        SceneError: A study of the program itself, and only the installed package is there.
    """
    *_, place = STUDIES[options.study]
    options.repeated = repeated(options.words)
    try:
        run: Callable[[argparse.Namespace], int] = resolve_name(place)
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("benchmarks"):
            raise
        needs = "needs benchmarks/ of rockslip's repository: call ./in-env rockslip there"
        raise Statement(f"study {options.study}", needs) from None
    return run(options)


def repeated(words: Sequence[str]) -> str:
    """The command of these words, without those that only say how and where a study is run."""
    how = argparse.ArgumentParser(add_help=False)
    _add_keeping(how, "")
    return shlex.join(["rockslip", *how.parse_known_args(words)[1]])


def _add_keeping(parser: argparse.ArgumentParser, kind: str) -> None:
    """Options of studies that are kept in a folder and can be gone on with."""
    add, noun = parser.add_argument, "suite" if kind == "suite" else "study"
    add("-j", dest="processes", type=int, metavar="N", help="processes; default one a processor")
    add("-o", "--output", metavar="DIR", type=Path, help=f"default SCENE's name + .{kind}")
    add("-q", "--quiet", action="store_true", help="say nothing but errors")
    again = parser.add_mutually_exclusive_group()
    again.add_argument("--force", action="store_true", help=f"write over an earlier {noun}")
    again.add_argument("--resume", action="store_true", help=f"go on with an earlier {noun}")


def _add_motions(parser: argparse.ArgumentParser, count: int) -> None:
    """Options of studies of many motions."""
    add = parser.add_argument
    add(
        *("--motions", "--motion"), metavar="MOTION", nargs="+", action="extend", default=[],
        help="files, folders of files, @FILE with a name a line, or synthetic (the default)",
    )  # fmt: skip
    add("--count", type=int, metavar="N", help=f"number of synthetic motions, default {count}")
    add("--seed", type=int, metavar="S", help="of the synthetic motions")


def _damping(parser: argparse.ArgumentParser) -> None:
    """Options of `study damping`."""
    add = parser.add_argument
    add_scene(parser)
    add_overrides(parser, example="time.end=1.5")
    add(
        "--of", metavar="NAME[=V1,V2,...]", nargs="+", action="extend", default=[],
        help="what is varied, such as beta=0,1e-5,1e-4: step, tolerance, mesh, gamma, rho_inf, "
        "damped_steps, beta, contact, young, floor; default all",
    )  # fmt: skip
    add(
        "--target", metavar="WHAT",
        help="find the damping instead: restitution=0.936, or history=FILE (time, angle)",
    )  # fmt: skip
    add("--impacts", type=int, default=4, metavar="N", help="that count, default %(default)s")
    add("--block", metavar="NAME", help="whose impacts count; default the first with a mesh")
    _add_keeping(parser, "damping")


def _error_runtime(parser: argparse.ArgumentParser) -> None:
    """Options of `study error-runtime`."""
    add = parser.add_argument
    add_scene(parser)
    add_overrides(parser, example="time.step=5e-4")
    add("-o", "--output", metavar="DIR", type=Path, help="default: SCENE's name + .errors")
    add("--force", action="store_true", help="write over an earlier study")
    add("-q", "--quiet", action="store_true", help="say nothing but errors")
    add(
        "--families", metavar="NAME", nargs="+",
        help="varied besides step: adaptive, mesh, degree, points, rho_inf, model; default all",
    )  # fmt: skip
    add(
        "--measures", metavar="NAME", nargs="+", default=[],
        help="what is judged, such as first_impact or peak_drift; default: all there is",
    )  # fmt: skip
    add("--rungs", type=int, default=6, metavar="N", help="steps of a ladder, 2 to 12; default 6")
    add("--repeat", type=int, default=3, metavar="N", help="times each run is made; default 3")
    add(
        "--longest", type=float, default=60.0, metavar="S",
        help="leave out runs that would take longer than this many seconds; default 60",
    )  # fmt: skip
    add(
        "--target", type=float, default=1.0, metavar="PERCENT",
        help="error for which to say what to use; default 1",
    )  # fmt: skip
    add(
        "--beside", metavar="FILE", type=Path,
        help="CSV with points of other programs: program, measure, error, seconds, note",
    )  # fmt: skip
    add(
        "--answer", metavar="SCENE", type=Path,
        help="another scene, with the same rigid-body answer, such as one in the plane",
    )  # fmt: skip


def _horizon(parser: argparse.ArgumentParser) -> None:
    """Options of `study horizon`."""
    add = parser.add_argument
    add_scene(parser)
    add_overrides(parser, example="time.end=20")
    add("--differences", default="1e-6", metavar="D,...",
        help="of amplitudes between a run and its twins, default %(default)s")  # fmt: skip
    add("--scales", default="1", metavar="F,...", help="factors on the motion, default 1")
    add("--engines", metavar="NAMES", help="of rigid, elastic; default the scene as it is")
    _add_keeping(parser, "horizon")


def _inertia(parser: argparse.ArgumentParser) -> None:
    """Options of `study inertia`."""
    add = parser.add_argument
    add_scene(parser, text="a TOML file; its motion and end are replaced")
    add_overrides(parser, example="foundation.mass_ratio=1")
    add(
        "--of", metavar="NAME=V1,V2,...", nargs="+", action="extend", default=[],
        help=f"axes of the map: {AXES}; default 6 periods x 8 friction coefficients",
    )  # fmt: skip
    add(
        "--by", nargs="+", choices=("rigid", "elements"), action="extend", default=[],
        help="besides a block that slides: rigid blocks, finite elements",
    )  # fmt: skip
    _add_motions(parser, 300)
    _add_keeping(parser, "inertia")


def _modes(parser: argparse.ArgumentParser) -> None:
    """Options of `study modes`."""
    add = parser.add_argument
    add_scene(parser, text="a TOML file with one block at rest; its motion and end are replaced")
    add_overrides(parser, example="block.width=0.5")
    add("--ratios", metavar="H/B,...", help="aspect ratios H/B; default that of the scene")
    add("--points", type=int, default=12, metavar="N", help="a side, default %(default)s")
    text = "rigid and elastic blocks; default: both, or rigid where the block has no young, poisson"
    add("--engines", metavar="NAMES", help=text)
    _add_keeping(parser, "modes")


def _overturning(parser: argparse.ArgumentParser) -> None:
    """Options of `study overturning`."""
    add = parser.add_argument
    add_scene(parser, text="a TOML file with one block at rest; its motion and end are replaced")
    add_overrides(parser, example="contact.friction=3")
    add("--pulses", default=PULSES, metavar="NAMES",
        help="of half_sine, one_sine, ricker; default %(default)s")  # fmt: skip
    add("--frequencies", default=FREQUENCIES, metavar="OMEGA/P",
        help="V1,V2,... or LOW:HIGH:COUNT, default %(default)s")  # fmt: skip
    add("--amplitudes", default=AMPLITUDES, metavar="LOW:HIGH:COUNT",
        help="of the scan, over g tan alpha, default %(default)s")  # fmt: skip
    add("--restitution", metavar="E,...", help="of rigid blocks; default the scene's, or Housner's")
    add("--rounds", type=int, default=2, metavar="N",
        help="how often frequencies are added where intervals begin or end; default 2")  # fmt: skip
    add("--elastic", metavar="OMEGA/P", help="frequencies at which the elastic block is run, too")
    _add_keeping(parser, "overturning")


def _stability(parser: argparse.ArgumentParser) -> None:
    """Options of `study stability`."""
    add = parser.add_argument
    add(
        "--family", dest="families", metavar="NAME", nargs="+", default=[],
        help="only these families: beginnings of their names",
    )  # fmt: skip
    add("--random", type=int, metavar="N", default=0, help="so many random scenes instead")
    add("--seed", type=int, metavar="S", default=1, help="of the random scenes, default 1")
    add("--limit", type=float, metavar="S", default=120.0, help="wall time a scene, default 120 s")
    add("-j", dest="processes", type=int, metavar="N", help="processes; default one a processor")
    add("-o", "--output", metavar="DIR", type=Path, default=Path("stability"), help="folder")
    add("--force", action="store_true", help="write over an earlier study")
    add("-q", "--quiet", action="store_true", help="say nothing but errors")


def _suite(parser: argparse.ArgumentParser) -> None:
    """Options of `study suite`."""
    add = parser.add_argument
    add_scene(parser, text="a TOML file; its motion and end are replaced")
    _add_motions(parser, 30)
    add_overrides(parser)
    add(
        "--vary", metavar="KEY=V1,V2,...", nargs="+", action="extend", default=[],
        help="run all motions with each of these values, such as contact.friction=0.1,0.2",
    )  # fmt: skip
    add(
        "--levels", metavar="V1,V2,...",
        help="scale each motion to these intensities, or LOW:HIGH:COUNT",
    )  # fmt: skip
    add("--intensity", metavar="IM", help="of the levels: PGA or PSA:T (g), PGV (m/s); default PGA")
    how = ("RotD50", "geomean", "larger")
    add("--horizontal", metavar="HOW", choices=how,
        help=f"how two horizontal components are measured: {', '.join(how)}; default {how[0]}",
    )  # fmt: skip
    add("--engines", metavar="NAMES", help="of rigid, elastic, ode, beside each other")
    add("--tail", type=float, default=0.0, metavar="S", help="go on after the motion, s; default 0")
    add("--reference", action="store_true", help="the rigid-body answer beside each run")
    add("--keep", action="store_true", help="keep all files of each run, in DIR/runs")
    _add_keeping(parser, "suite")


STUDIES = {
    "damping": (
        "restitution of impacts over step, mesh, damping and others; damping for a restitution",
        _damping,
        "solver.study.damping.cases:run",
    ),
    "error-runtime": (
        "error against run time: ladders of step, tolerance, mesh, degree, points, rho_inf, model",
        _error_runtime,
        "benchmarks.error_runtime.run:run",
    ),
    "horizon": (
        "up to when a history means something: runs of which amplitudes differ by a millionth",
        _horizon,
        "solver.study.horizon.cases:HorizonStudy.run",
    ),
    "inertia": (
        "the portion of the live load that counts as inertia, with its interval, over maps",
        _inertia,
        "solver.study.inertia.cases:InertiaStudy.run",
    ),
    "modes": (
        "rest, slide, rock or both: how a block at rest begins to move, against Shenton (1996)",
        _modes,
        "solver.study.modes.cases:ModesStudy.run",
    ),
    "overturning": (
        "amplitudes of pulses that overturn a block, over their frequency: all intervals",
        _overturning,
        "solver.study.overturning.cases:OverturningStudy.run",
    ),
    "stability": (
        "scenes driven far, each with a verdict: held, refused by name, or failed",
        _stability,
        "benchmarks.stability.run:run",
    ),
    "suite": (
        "one scene under many motions side by side: records, tables, synthetic ones",
        _suite,
        "solver.study.suite.cases:SuiteStudy.run",
    ),
}
"""Purpose of each study in words, the function that adds its options, the place that runs it."""
