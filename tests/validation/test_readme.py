"""Every command line and Python snippet of README, CONTRIBUTING and docs, in a short form.

Commands are read from the pages, so that a new one is run, too. What is not run is at least held to
the parser, the Makefile or the tree, and has its reason in `reason_not_to_run`.
"""

from __future__ import annotations

import contextlib
import importlib.util
import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import python

from solver.cli import build_parser, main
from solver.run.folders import LEFT_BEHIND

pytestmark = [pytest.mark.serial, pytest.mark.slow]

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))

#: First words of a command line, after `./in-env`.
PROGRAMS = ("rockslip", "mpirun", "make", "docker", "python3", "paraview", "pvpython")

SCENE = """
[[block]]
width = 1.0
height = 0.5
mass = 1000.0
young = 5.0e10
poisson = 0.2
cells = [3, 2]
[foundation]
kind = "oscillator"
mass_ratio = 2.0
period = 0.5
damping_ratio = 0.05
[contact]
friction = 0.2
[motion]
kind = "sine"
amplitude_g = 0.4
period = 0.6
[time]
end = 0.02
step = 1.0e-3
"""

RECORD = """PEER STRONG MOTION DATA
A QUAKE
ACCELERATION TIME SERIES IN UNITS OF G
NPTS= 6, DT= .05 SEC
0.1 0.2 0.1 -0.1 -0.2 -0.1
"""

#: Steps that suffice to see that a study runs.
TINY_STUDY = ("--set", "block.model=rigid", "time.step=0.05", "time.end=0.5")


def code_blocks(page: Path) -> Iterator[list[str]]:
    """The lines of fenced blocks, and of those indented by four blanks after an empty line."""
    text = page.read_text(encoding="utf-8")
    fenced = re.compile(r"^ *```.*\n((?:.*\n)*?) *```", re.MULTILINE)
    for match in fenced.finditer(text):
        yield match[1].splitlines()
    indented = re.compile(r"(?:^|\n\n)((?: {4}.*\n)(?:\n*(?: {4}.*\n))*)")
    for match in indented.finditer(fenced.sub("", text)):
        yield [line[4:] for line in match[1].splitlines()]


def command_lines(page: Path) -> Iterator[str]:
    """Command lines of the code blocks, without comments, `./in-env` and line breaks."""
    for block in code_blocks(page):
        text = re.sub(r"\s*\\?\n\s+", " ", "\n".join(re.sub(r"\s+# .*", "", x) for x in block))
        for line in text.splitlines():
            command = line.removeprefix("$ ").removeprefix("./in-env ")
            if command.split(maxsplit=1)[:1] and command.split()[0] in PROGRAMS:
                yield command
    for command in re.findall(r"`(?:\./in-env|make) [^`]+`", page.read_text(encoding="utf-8")):
        if "COMMAND" not in command and not command.startswith("`./in-env --"):
            yield command.strip("`").removeprefix("./in-env ")


def found() -> list[tuple[str, str]]:
    """Name of the first page and command line, for every command line."""
    pages: dict[str, str] = {}
    for page in PAGES:
        for command in command_lines(page):
            pages.setdefault(command, page.name)
    return [(page, command) for command, page in pages.items()]


def reason_not_to_run(words: list[str]) -> str:
    """Reason why a command is not run here; empty where it is."""
    if words[0] == "docker":
        return "needs a container engine and an image"
    if words[0] in ("paraview", "pvpython"):
        return "ParaView is not in the environment"
    if words[0] == "make":
        return "sets up environments, runs whole demos or all tests"
    if words[0] == "python3":
        return "demos and benchmarks have short forms in tests of their own"
    if any(word.startswith("[") for word in words):
        return "a synopsis"
    if words[:3] == ["rockslip", "study", "stability"] and "--random" not in words:
        return "takes minutes to an hour; tests/unit/test_stability.py runs single scenes"
    if words[:3] == ["rockslip", "study", "damping"] and "floor" not in words:
        return "dozens of runs; tests/verification/test_study_damping.py has shorter ones"
    return ""


ALL = found()


def differing() -> list[tuple[str, str]]:
    """What is run: the first of commands that differ only in the number of ranks or in --force."""
    first: dict[str, tuple[str, str]] = {}
    for page, command in ALL:
        if not reason_not_to_run(shlex.split(command)):
            same = re.sub(r"^mpirun -n \d+", "mpirun", command).removesuffix(" --force")
            first.setdefault(same, (page, command))
    return list(first.values())


RUN = differing()


def shortened(words: list[str]) -> list[str]:
    """A command of rockslip with what makes it short, and allowed to write over what is there."""
    task = " ".join(words[1:3]) if words[1] == "study" else words[1]
    more: tuple[str, ...] = ()
    if task == "run" and "--resume" in words:
        # The scene is in the folder.
        return ["time.end=0.04" if word.startswith("time.end=") else word for word in words]
    if task in ("run", "reference"):
        more = ("--set", "time.end=0.02", "--force")
    elif task == "animate":
        more = ("--from", "0", "--until", "0.02", "--slow", "5", "--width", "320")
    elif task == "report":
        more = ("--no-film",)
    elif task == "study suite":
        synthetic = "synthetic" in words or "--motions" not in words
        more = (*TINY_STUDY, "-j", "1", *(("--count", "1") if synthetic else ()))
        more += () if "--resume" in words else ("--force",)
    elif task == "study inertia":
        if "--count" in words:
            at = words.index("--count")
            words = [*words[:at], *words[at + 2 :]]
        more = (*TINY_STUDY, "--motions", "a.AT2", "-j", "1")
        more += () if "--resume" in words else ("--force",)
    elif task == "study error-runtime":
        more = (*TINY_STUDY, "--rungs", "2", "--repeat", "1", "--force")
    elif task == "study stability":
        at = words.index("--random") + 1
        words = [*words[:at], "1", *words[at + 1 :]]
        more = ("--force",)
    elif task == "study modes":
        more = ("--points", "2", "--engines", "rigid", "-j", "1", "--force")
    elif task == "study overturning":
        tiny = ("--frequencies", "4", "--amplitudes", "2:4:3", "--rounds", "0", "-j", "1")
        if "--elastic" in words:
            at = words.index("--elastic")
            words = [*words[:at], *words[at + 2 :]]
        more = (*tiny, *(() if "--resume" in words else ("--force",)))
    elif task == "study horizon":
        tiny = TINY_STUDY if words[3] == "scene.toml" else ("--set", *TINY_STUDY[2:])
        more = (*tiny, "-j", "1", *(() if "--resume" in words else ("--force",)))
    elif task == "study damping":
        words[3:4] = ["demos/free_rocking/scene.toml"]
        coarse = ("block.cells=[1,2]", "time.end=0.2", "time.tolerance=1")
        more = ("--impacts", "1", "-j", "1", "--force", "--set", *coarse)
    return [*words, *more]


def call(folder: Path, words: list[str]) -> None:
    """Run a command of rockslip in a folder, here or by mpirun on two ranks."""
    if words[0] != "mpirun":
        with contextlib.chdir(folder):
            assert main(shortened(words)[1:]) == 0
        return
    started(folder, "-m", *shortened(words[words.index("rockslip") :]), ranks=2)


def started(folder: Path, *words: str, ranks: int = 1) -> str:
    """The output of Python in processes of its own."""
    done = python(*words, ranks=ranks, folder=folder)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def furnished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all that the commands name: scenes, records, lists, a run and its reference."""
    for package in ("dolfinx", "gmsh", "matplotlib", "pyvista"):
        pytest.importorskip(package)
    folder = tmp_path_factory.mktemp("pages")
    (folder / "scene.toml").write_text(SCENE)
    for file in ("a.AT2", "records/b.AT2"):
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text(RECORD)
    for name in ("list.txt", "table1.txt"):
        (folder / name).write_text("a.AT2\n")
    for kind in ("toml", "stl"):
        for file in ROOT.glob(f"demos/*/*.{kind}"):
            copy = folder / file.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
    for task, output in (("run", "out"), ("run", "elastic"), ("reference", "rigid")):
        call(folder, ["rockslip", task, "scene.toml", "-o", output])
    return folder


@pytest.fixture
def folder(furnished: Path, tmp_path: Path) -> Path:
    """A copy of what the commands name, of its own for each."""
    return Path(shutil.copytree(furnished, tmp_path / "work"))


def _marked(command: tuple[str, str]) -> object:
    marks = [pytest.mark.mpi] if command[1].startswith("mpirun") else []
    return pytest.param(command[1], marks=marks, id=f"{command[0]}: {command[1]}")


@pytest.mark.parametrize("command", [_marked(each) for each in RUN])
def test_command_lines_run(folder: Path, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("solver.study.inertia.numbers.RESAMPLES", 20)
    words = shlex.split(command)
    if "run" in words and "--resume" in words:
        at, saved = words.index("--resume"), ["--set", "output.checkpoint={steps=5}"]
        call(folder, [*words[:at], "scene.toml", "-o", words[at + 1], *saved])
    elif "--resume" in words:
        call(folder, [*(word for word in words if word != "--resume"), "--force"])
    call(folder, words)


@pytest.mark.parametrize("command", [each[1] for each in ALL if each not in RUN])
def test_what_is_not_run_is_there(command: str) -> None:
    """Commands are known to the parser, targets to the Makefile, scripts and options exist."""
    words = shlex.split(command)
    if words[0] == "make":
        targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
        assert words[1] in targets
    elif words[:2] == ["python3", "-m"]:
        found = importlib.util.find_spec(words[2])
        assert found is not None
        if found.submodule_search_locations is not None:
            assert importlib.util.find_spec(f"{words[2]}.__main__") is not None
    elif words[0] == "python3":
        assert (ROOT / next(word for word in words if word.endswith(".py"))).is_file()
    elif words[0] in ("paraview", "pvpython"):
        assert words[1].removeprefix("--script=") in LEFT_BEHIND
    elif "synopsis" in reason_not_to_run(words):
        options = re.findall(r"-{1,2}[a-z][a-z-]*", command.split("[", 1)[1])
        printed = started(Path.cwd(), "-m", *words[:3], "--help")
        assert options and all(option in printed for option in options)
    elif words[0] in ("rockslip", "mpirun"):
        arguments = words[words.index("rockslip") + 1 :]
        assert build_parser().parse_args(arguments).action is not None


def test_the_pages_have_commands() -> None:
    """Nothing is lost where pages are written in another way."""
    assert len(RUN) > 12
    tasks = {command.split()[1] for _, command in RUN if command.startswith("rockslip ")}
    single = {"run", "check", "reference", "scale", "plot", "animate", "report", "info"}
    assert tasks == single | {"study"}


SNIPPETS = [
    pytest.param("\n".join(block), id=f"{page.name}: {block[0]}")
    for page in PAGES
    if page.name != "python.md"  # which is one script: `tests/unit/test_python.py`
    for block in code_blocks(page)
    if block and block[0].startswith(("from ", "import "))
]


@pytest.mark.parametrize("snippet", SNIPPETS)
def test_python_snippets_run(folder: Path, snippet: str) -> None:
    """As they stand, beside a scene; what they give a name to is there."""
    names = re.findall(r"^(\w+) = ", snippet, re.MULTILINE)
    assert names
    check = f"assert all(value is not None for value in ({', '.join(names)},))"
    started(folder, "-c", f"{snippet}\n{check}\n")


def test_readme_has_a_snippet() -> None:
    assert any(str(snippet.id).startswith("README.md") for snippet in SNIPPETS)
