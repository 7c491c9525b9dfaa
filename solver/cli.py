"""The command `rockslip`.

Heavy imports stand inside the commands that need them. Exit codes: 0 done, 2 bad input, 3 not
converged, 4 environment or no space left, 130 interrupted.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from solver import VERSION
from solver.arguments import add_overrides, add_scene
from solver.errors import (
    NO_ROOM,
    UNUSABLE,
    NotConverged,
    OutputTrouble,
    RockslipError,
    SceneError,
    missing_key,
    not_applicable,
    not_installed,
)
from solver.parallel import launched_rank
from solver.pictures.command import add_pictures
from solver.run.folders import claim_folder, release_folders
from solver.run.streams import FULL, guard_streams, say, tell
from solver.scene.checking import nearest
from solver.study.command import add_studies
from solver.study.page import add_report

if TYPE_CHECKING:
    from solver.excitation.motion import GroundMotion
    from solver.scene import Scene

#: Exit code of a run that was stopped by Ctrl-C or SIGTERM.
INTERRUPTED = 130


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are one line, with the word that was meant."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Read the words; unknown options are errors."""
        found, rest = super().parse_known_args(args, namespace)
        for word in rest:
            if word.startswith("-"):
                self.error(f"no option {word}{_hint(word, self._option_string_actions)}")
        return found, rest

    def error(self, message: str) -> NoReturn:
        """Bad input, as everywhere: one line, exit code 2."""
        choice = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)$", message)
        hint = _hint(choice[1], re.findall(r"[\w-]+", choice[2])) if choice else ""
        if launched_rank() == 0:
            tell(f"rockslip: {message}{hint} (see {self.prog} --help)\n")
        sys.exit(SceneError.exit_code)


def _hint(word: str, words: Iterable[str]) -> str:
    """The word that was probably meant, if there is one."""
    meant = nearest(word, words)
    return f", did you mean '{meant}'?" if meant else ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, without the name of the program; returns its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with guard_streams():
            return _main(words)
    finally:
        release_folders()


def _main(words: list[str]) -> int:
    """Run the command line while standard output and error last."""
    # What follows "--" is for PETSc, not for argparse
    cut = words.index("--") if "--" in words else len(words)
    parser = build_parser()
    options = parser.parse_args(words[:cut])
    if options.command is None:
        if launched_rank() == 0:
            parser.print_help()
        return 0
    if words[cut + 1 :] and options.command != "run":
        parser.error("options after -- are for `rockslip run`")
    options.words, options.petsc_options = words[:cut], tuple(words[cut + 1 :])
    try:
        return int(options.action(options))
    except KeyboardInterrupt:  # before or after a run itself, which handles signals on its own
        if options.command == "study" and "resume" in options and launched_rank() == 0:
            tell("rockslip: interrupted; --resume goes on with what is missing\n")
        return INTERRUPTED
    except RockslipError as error:
        if launched_rank() == 0:
            tell(f"rockslip: {error}\n")
        return error.exit_code
    except OSError as error:
        if error.errno not in NO_ROOM and not (error.errno in UNUSABLE and error.filename):
            raise
        # Whoever writes alone; what ranks write together is an OutputTrouble on all of them.
        tell(f"rockslip: {OutputTrouble.of(error)}\n")
        from solver.parallel import abort_others

        abort_others(OutputTrouble.exit_code)
        return OutputTrouble.exit_code


def build_parser() -> Parser:
    """All commands and their options."""
    parser = Parser(
        prog="rockslip",
        description="Rocking and sliding of blocks under base motion, by finite elements.",
        epilog="Exit codes: 0 done, 2 bad input, 3 not converged, "
        "4 environment or no space left, 130 interrupted.",
    )
    parser.add_argument("--version", action="version", version=f"rockslip {VERSION}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")

    def command(name: str, action: Callable[[argparse.Namespace], int], text: str) -> Any:
        added = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        added.set_defaults(action=action)
        return added

    run = command("run", run_scene, "simulate a scene; options for PETSc follow after --")
    check = command("check", check_scene, "derived numbers, expected mode, mesh size; no solve")
    reference = command("reference", run_reference, "the rigid-body answer, with the same files")
    for scene_command in (run, check, reference):
        add_scene(scene_command, needed=scene_command is not run)
        add_overrides(scene_command)
    for writing, default in ((run, "SCENE's name + .out"), (reference, "SCENE's name + .rigid")):
        writing.add_argument(
            "-o", "--output", metavar="DIR", type=Path, help=f"folder to write; default {default}"
        )
        writing.add_argument("--force", action="store_true", help="write over an earlier run")
        writing.add_argument("-q", "--quiet", action="store_true", help="say nothing but errors")
    again = "go on from the checkpoint of a run in DIR, also to a later time.end (--set)"
    run.add_argument("--resume", metavar="DIR", type=Path, help=again)
    run.add_argument("-v", "--verbose", action="store_true", help="print the log of the solver")
    scale = command("scale", scale_scene, "a scene at another scale, such as a 1:15 model of it")
    add_scene(scale)
    add_overrides(scale)
    scale.add_argument(
        *("--lengths", "-l"),
        metavar="N",
        type=float,
        required=True,
        help="lengths become 1/N, times 1/sqrt(N), accelerations stay",
    )
    scale.add_argument(
        "--keep",
        choices=("density", "young"),
        default="density",
        help="of the material: moduli become 1/N, masses 1/N^3; or masses 1/N^2; default density",
    )
    scale.add_argument("-o", "--output", metavar="FILE", type=Path, help="default standard output")
    add_pictures(command)
    add_report(command)
    add_studies(command("study", show_info, "many runs of a scene, and what they say together"))
    command("info", show_info, "versions of everything that matters, ranks, solvers found")
    return parser


def _tell_before(scene: Scene, ground: GroundMotion, ranks: int, folder: Path) -> None:
    """Say before a run what to be careful of, and on several ranks where it writes."""
    from solver.results.cautions import cautions_of_input

    for text in cautions_of_input(scene, ground):
        tell(f"caution: {text}\n")
    if ranks > 1:
        # Now: an mpirun that is interrupted passes on nothing of what ranks say after that.
        tell(f"writing to {folder}, up to the last step where it is interrupted\n")


def run_scene(options: argparse.Namespace) -> int:
    """`rockslip run`: rank 0 reads scene and motion, all ranks run it."""
    from solver.excitation.motion import read_ground
    from solver.parallel import abort_on_exceptions, on_first_rank, world
    from solver.scene import load_scene
    from solver.stepping.petsc_options import command_line, parse_options

    try:
        comm = world()
    except ImportError as error:
        raise not_installed(error) from error
    abort_on_exceptions(comm)
    given = parse_options(options.petsc_options)  # refused before anything is written
    if options.scene is None and options.resume is None:
        raise missing_key("SCENE", "or --resume DIR (see rockslip run --help)")
    path = _resumed_scene(options) if options.resume else options.scene
    # Files are read by rank 0 alone. What cannot be read is refused before anything is written.
    scene = on_first_rank(comm, lambda: load_scene(path, options.overrides))
    ground = read_ground(scene, comm)
    try:
        comm = world(meshed=not scene.is_rigid)
        from solver.run.simulate import simulate

        if not scene.is_rigid:
            if given:
                import petsc4py

                # In the end PETSc says which options it knew nothing of.
                petsc4py.init(["rockslip", "-options_left", *command_line(given)])
            import_module("dolfinx")
        if given and not scene.is_rigid:  # without a mesh they are of no use
            import_module(
                "solver.bodies.packed_form"
            )  # PETSc takes SIGPIPE over, and this takes it back
            from solver.stepping.nonlinear import check_options

            check_options()
    except ImportError as error:
        raise not_installed(error) from error
    folder = options.resume or options.output or Path(_stem(path) + ".out")
    if not options.resume:
        on_first_rank(comm, lambda: claim_folder(folder, path, options.force))
    from solver.results.report import report
    from solver.run.progress import Progress

    if comm.rank == 0 and not options.quiet:
        _tell_before(scene, ground, comm.size, folder)
    result = simulate(
        scene,
        folder=folder,
        progress=Progress(scene.time.end, quiet=options.quiet, rank=comm.rank),
        log=_tell if options.verbose and comm.rank == 0 else None,
        comm=comm,
        ground=ground,
        resume=options.resume is not None,
    )
    if comm.rank == 0 and not options.quiet:
        say(report(result.summary))
        say(f"written to {folder}; pictures: rockslip plot {folder}\n")
    codes = {"not converged": NotConverged.exit_code, "interrupted": INTERRUPTED}
    ended = result.summary.get("horizon", result.summary)["status"]  # of the twin, which comes last
    return codes.get(result.status, INTERRUPTED if ended == "interrupted" else 0)


def _resumed_scene(options: argparse.Namespace) -> Path:
    """The scene in the folder of a run that goes on, as it was run, but for a later end."""
    given = {"SCENE": options.scene, "-o": options.output, "--force": options.force}
    given["--set of other keys than time.end"] = [
        text for text in options.overrides if text.partition("=")[0].strip() != "time.end"
    ]
    for name, value in given.items():
        if value:
            raise not_applicable(name, "runs that begin, not to --resume DIR")
    return Path(options.resume) / "scene.toml"


def check_scene(options: argparse.Namespace) -> int:
    """`rockslip check`."""
    if launched_rank() == 0:
        from solver.run.describe import describe
        from solver.scene import load_scene

        say(describe(load_scene(options.scene, options.overrides)))
    return OutputTrouble.exit_code if FULL else 0


def run_reference(options: argparse.Namespace) -> int:
    """`rockslip reference`: one rank does it, in the time that the others need to leave."""
    if launched_rank() != 0:
        return 0
    from solver.excitation.motion import read_ground
    from solver.reference.answer import reference_name, reference_run
    from solver.results.cautions import cautions_of_input
    from solver.results.report import report
    from solver.results.summary import summarise, write_json, write_whole
    from solver.scene import load_scene, scene_to_toml

    scene = load_scene(options.scene, options.overrides)
    ground = read_ground(scene)
    model = reference_name(scene, ground)  # refused before anything is written
    folder = options.output or Path(_stem(options.scene) + ".rigid")
    claim_folder(folder, options.scene, options.force)
    began = time.monotonic()
    history, reason = reference_run(scene, folder / "history.csv", ground)
    summary = summarise(
        scene,
        history,
        status="completed",
        cost={"wall_s": time.monotonic() - began, "ranks": 1},
        versions={"rockslip": VERSION},
        reason=reason,
        model=model,
        cautions=cautions_of_input(scene, ground),
        ground=ground,
    )
    write_whole(folder / "scene.toml", scene_to_toml(scene))
    write_json(folder / "summary.json", summary)
    if not options.quiet:
        say(f"{summary['model']}\n{report(summary)}written to {folder}\n")
    return 0


def scale_scene(options: argparse.Namespace) -> int:
    """`rockslip scale`."""
    if launched_rank() == 0:
        from solver.run.rescale import rescaled
        from solver.scene import load_scene
        from solver.scene.scaling import Scale

        if not 0 < options.lengths < float("inf"):
            raise SceneError("--lengths", f"{options.lengths:g}", "a number > 0")
        scene = load_scene(options.scene, options.overrides)
        text = rescaled(scene, Scale(1 / options.lengths, options.keep), options.output)
        say(f"written to {options.output}\n" if options.output else text)
    return OutputTrouble.exit_code if FULL else 0


def _stem(scene: Path) -> str:
    """The name for the folder of a run: that of the scene, "scene" for the standard input."""
    return "scene" if str(scene) == "-" else scene.stem


def show_info(options: argparse.Namespace) -> int:
    """`rockslip info`: every rank starts MPI, the first one prints."""
    from solver.bodies.memory import limits_in_words
    from solver.info import description, table
    from solver.kernels.library import library

    lines = description()
    lines.append(("kernels", f"{library().SOURCES} ({library().__file__})"))
    lines.append(("linear solver", limits_in_words(int(dict(lines)["ranks"]))))
    if launched_rank() == 0:
        say(table(lines))
    return OutputTrouble.exit_code if FULL else 0


def _tell(line: str) -> None:
    """Write a line of the log."""
    tell(line.rstrip("\n") + "\n")
