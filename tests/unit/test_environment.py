"""The choices of ./in-env: which way it takes, what it says, what it hands on.

Its neighbours (python3, docker, podman, buildah, ...) are small scripts in a folder that is all of
PATH; each writes down how it was called.
"""

import os
import re
import shlex
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

pytestmark = pytest.mark.serial

REPOSITORY = Path(__file__).resolve().parents[2]
TOOLS = (
    "bash cat chmod cksum cut dirname env find flock head mkdir mktemp mv readlink rm sed sh"
    " sha256sum sleep sort tail touch tr true"
).split()
ENGINE = """
case $1 in
--version) echo "{name} version 1" ;;
info) [ $# -eq 1 ] || echo "{security}" ;;
image) [ -e "$LOG.built" ] ;;
build) touch "$LOG.built" ;;
run) exit 3 ;;
esac
"""

COMPILER = """
case $1 in
--version) echo "g++ 14" ;;
*) {first}; for file in "$@"; do :; done; echo library >"$file" ;;
esac
"""

BUILDAH = """
case $1 in
inspect) [ -e "$LOG.built" ] && echo OMP_NUM_THREADS=1 ;;
pull) exit 1 ;;
bud) touch "$LOG.built" ;;
from) touch "$LOG.kept.$2"; echo base ;;
mount) [ -e "$LOG.kept.--pull-never" ] && echo {root} ;;
esac
"""


class Machine:
    """A machine with nothing on it but what a test installs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.bin = folder / "bin"
        self.home = folder / "home"
        self.log = folder / "log"
        self.current = folder / "current folder"
        for made in (self.bin, self.home, self.current):
            made.mkdir()
        for tool in TOOLS:
            found = shutil.which(tool)
            if found is not None:
                (self.bin / tool).symlink_to(found)
        self.install("python3", "exit 1")
        self.install("id", "echo 1000")
        self.install_compiler()

    def install(self, name: str, body: str = "") -> None:
        script = self.bin / name
        script.write_text(f'#!/bin/sh\necho "{name} $*" >>"$LOG"\n{body}\n')
        script.chmod(0o755)

    def install_engine(self, name: str, security: str = "[]") -> None:
        self.install(name, ENGINE.format(name=name, security=security))

    def install_compiler(self, first: str = ":") -> None:
        """A compiler of kernels that does something first."""
        self.install("g++", COMPILER.format(first=first))

    def install_debian(self) -> None:
        """Root on Debian; buildah has no images and reaches no registry."""
        root = self.folder / "image"
        (root / "usr/bin").mkdir(parents=True)
        (root / "usr/bin/env").symlink_to("/usr/bin/env")
        self.install("id", "echo 0")
        self.install("apt-get")
        self.install("mmdebstrap")
        self.install("unshare", "exit 3")
        self.install("buildah", BUILDAH.format(root=shlex.quote(str(root))))

    def environment(self, extra: Mapping[str, str]) -> dict[str, str]:
        return {"PATH": str(self.bin), "HOME": str(self.home), "LOG": str(self.log), **extra}

    def in_env(
        self, *command: str, cwd: Path | None = None, script: Path | None = None, **extra: str
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [script or REPOSITORY / "in-env", *command],
            cwd=cwd or self.current,
            env=self.environment(extra),
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    def calls(self, start: str) -> list[str]:
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return [line for line in lines if line.startswith(start)]


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_without_a_command_it_explains_itself(machine: Machine) -> None:
    wrong, asked = machine.in_env(), machine.in_env("--help")
    assert (wrong.returncode, asked.returncode) == (2, 0)
    assert wrong.stderr == asked.stdout
    assert asked.stdout.startswith("Usage: ./in-env COMMAND")
    assert "ROCKSLIP_MOUNT" in asked.stdout and "set -euo" not in asked.stdout


def test_without_any_way_one_message_names_all_three(machine: Machine) -> None:
    done = machine.in_env("true")
    assert done.returncode == 4
    assert done.stdout == ""
    assert done.stderr.startswith("in-env: found no way to dolfinx >= 0.9. ")
    for word in (
        "apt install g++ python3-dolfinx",
        "conda install",
        "Docker or Podman",
        "sudo ./in-env",
    ):
        assert word in done.stderr


@pytest.mark.parametrize("here", [True, False])
def test_a_cache_that_cannot_be_made_is_one_line(machine: Machine, here: bool) -> None:
    if here:
        machine.install("python3")
    (machine.folder / "file").touch()
    cache = machine.folder / "file" / "cache"
    done = machine.in_env("true", ROCKSLIP_CACHE=str(cache))
    assert (done.returncode, done.stdout) == (4, "")
    line = "cannot be made or written to: set ROCKSLIP_CACHE to a folder of your own"
    assert done.stderr == f"in-env: {cache} {line}\n"


def test_this_python_comes_first(machine: Machine) -> None:
    machine.install("python3")
    machine.install_engine("docker")
    done = machine.in_env("sh", "-c", 'echo "$PYTHONPATH"; exit 3', PYTHONPATH="/elsewhere")
    assert done.returncode == 3
    assert done.stdout == f"{REPOSITORY}:/elsewhere\n"
    assert machine.calls("docker") == []


def test_the_command_rockslip_is_the_program_of_this_repository(machine: Machine) -> None:
    machine.install("python3")
    assert machine.in_env("rockslip", "run", "a b.toml").returncode == 0
    assert machine.calls("python3 -m") == ["python3 -m rockslip run a b.toml"]


def test_a_place_with_paraview(machine: Machine) -> None:
    """A pvpython at hand, or an image of its own, never the environment."""
    machine.install("python3")
    machine.install_engine("docker")
    wrong = machine.in_env("true", ROCKSLIP_TOOL="gimp")
    assert (wrong.returncode, wrong.stderr) == (
        2,
        "in-env: ROCKSLIP_TOOL: got gimp, allowed paraview, or nothing\n",
    )
    assert machine.in_env("pvpython", "a.py", ROCKSLIP_TOOL="paraview").returncode == 3
    (built,) = machine.calls("docker build")
    assert "--target paraview" in built and "tests/in_paraview/Dockerfile" in built
    assert "rockslip-paraview:trixie-" in machine.calls("docker run")[0]
    machine.install("pvpython")
    assert machine.in_env("pvpython", "a.py", ROCKSLIP_TOOL="paraview").returncode == 0
    assert machine.calls("pvpython") == ["pvpython a.py"]


def test_another_suite_is_not_this_python(machine: Machine) -> None:
    machine.install("python3")
    assert machine.in_env("true", SUITE="sid").returncode == 4
    assert machine.in_env("true", SUITE="sid", ROCKSLIP_SUITE="trixie").returncode == 4
    assert machine.in_env("true", SUITE="sid", ROCKSLIP_SUITE="sid").returncode == 0


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_signal_reaches_the_command(machine: Machine, sent: signal.Signals) -> None:
    machine.install("python3")
    waiting = "trap 'exit 7' TERM INT HUP; echo ready; while :; do sleep 0.02; done"
    with subprocess.Popen(
        [REPOSITORY / "in-env", "sh", "-c", waiting],
        cwd=machine.current,
        env=machine.environment({}),
        stdout=subprocess.PIPE,
        text=True,
        # Tests may run where the signal is ignored (nohup), and what is ignored no shell can trap.
        preexec_fn=lambda: signal.signal(sent, signal.SIG_DFL),
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(sent)
        assert process.wait(timeout=60) == 7


def test_an_engine_builds_once_and_runs(machine: Machine) -> None:
    machine.install_engine("docker")
    machine.install_engine("podman")
    first, second = (machine.in_env("python3", "-c", "pass", CI="true") for _ in range(2))
    assert (first.returncode, second.returncode) == (3, 3)
    assert first.stderr.startswith("in-env: building rockslip-environment:trixie-")
    assert second.stderr == ""
    (built,) = machine.calls("docker build")
    assert " --build-arg SUITE=trixie --target environment " in built
    run, again = machine.calls("docker run")
    assert run == again
    for part in (
        "run --rm -i --init ",
        f" -v {REPOSITORY}:{REPOSITORY} ",
        f" -v {machine.current}:{machine.current} ",
        f" -v {machine.home}/.cache/rockslip/trixie:/cache ",
        f" -w {machine.current} ",
        f" env PYTHONPATH={REPOSITORY} HOME=/cache ",
        " CI=true ",
    ):
        assert part in run
    assert run.endswith(" python3 -c pass")
    assert machine.calls("podman") == []


def test_the_complete_image_is_built_on_request(machine: Machine) -> None:
    machine.install("python3")
    machine.install_engine("docker")
    assert machine.in_env("--image").returncode == 0
    stage, whole = machine.calls("docker build")
    assert " --target environment " in stage
    assert "--target" not in whole and " -t rockslip:latest " in whole
    assert machine.calls("docker run") == []


def test_an_engine_that_does_not_answer_is_passed_over(machine: Machine) -> None:
    machine.install("docker", "exit 1")
    machine.install_engine("podman")
    assert machine.in_env("true").returncode == 3
    assert len(machine.calls("podman run")) == 1


@pytest.mark.parametrize(
    ("engine", "security", "option"),
    [
        ("docker", "[name=seccomp]", " --user 1000:1000 "),
        ("docker", "[name=seccomp name=rootless]", None),
        ("podman", "[]", " --userns=keep-id "),
    ],
)
def test_files_belong_to_the_caller(
    machine: Machine, engine: str, security: str, option: str | None
) -> None:
    machine.install_engine(engine, security)
    machine.in_env("true")
    (run,) = machine.calls(f"{engine} run")
    if option is None:
        assert "--user" not in run
    else:
        assert option in run


def test_debian_as_root_builds_its_own_base_when_no_registry_answers(machine: Machine) -> None:
    machine.install_debian()
    assert machine.in_env("python3", "x y").returncode == 3
    order = [line.split()[1] for line in machine.calls("buildah")]
    wanted = "inspect inspect pull from add config commit rm bud mount from mount inspect"
    assert order == wanted.split()
    (made,) = machine.calls("mmdebstrap")
    assert made.split()[-2] == "trixie"
    run = machine.log.read_text().splitlines()[-1]  # the call of unshare carries a whole function
    assert f" -- /usr/bin/env -i -C {machine.current} OMP_NUM_THREADS=1 PYTHONPATH=" in run
    assert run.endswith(" python3 x y")
    assert machine.calls("apt-get") == []


def test_debian_as_root_builds_the_complete_image(machine: Machine) -> None:
    machine.install_debian()
    assert machine.in_env("--image").returncode == 0
    assert " -t rockslip:latest " in machine.calls("buildah bud")[-1]
    assert machine.calls("unshare") == []


def test_debian_as_root_keeps_what_it_built(machine: Machine) -> None:
    machine.install_debian()
    machine.in_env("true")
    before = len(machine.calls("buildah"))
    assert machine.in_env("true").returncode == 3
    assert len(machine.calls("buildah")) == before
    assert len(machine.calls("unshare")) == 2


def test_a_build_that_fails_says_so(machine: Machine) -> None:
    machine.install("docker", '[ "$1" = info ] || [ "$1" = --version ]')
    done = machine.in_env("true")
    assert done.returncode == 4
    assert done.stderr.splitlines()[-1].startswith("in-env: the environment could not be set up")


def test_one_way_can_be_insisted_on(machine: Machine) -> None:
    machine.install("python3")
    machine.install_engine("docker")
    assert machine.in_env("true", ROCKSLIP_WAY="2").returncode == 3
    done = machine.in_env("true", ROCKSLIP_WAY="3")
    assert done.returncode == 4
    assert "(only way 3 was tried)" in done.stderr
    done = machine.in_env("true", ROCKSLIP_WAY="4")
    assert (done.returncode, done.stderr) == (2, "in-env: ROCKSLIP_WAY: got 4, allowed 1, 2 or 3\n")


def test_folders_that_cannot_be_shown_are_refused(machine: Machine) -> None:
    machine.install_engine("docker")
    colon = machine.folder / "a:b"
    colon.mkdir()
    for cwd, extra, named in (
        (Path("/"), {}, "/ cannot be shown"),
        (colon, {}, "a colon in its path"),
        (None, {"ROCKSLIP_MOUNT": "/nowhere/at/all"}, "no such folder: /nowhere/at/all"),
    ):
        done = machine.in_env("true", cwd=cwd, **extra)
        assert done.returncode == 2
        assert named in done.stderr
    assert machine.calls("docker run") == []


def test_the_command_is_told_what_it_sees(machine: Machine) -> None:
    """ROCKSLIP_VISIBLE lists the folders that are shown; the machine's own Python sees them all."""
    shown = machine.folder / "shown"
    shown.mkdir()
    telling = ["sh", "-c", 'echo "${ROCKSLIP_VISIBLE:-all}"']
    machine.install("python3")
    assert machine.in_env(*telling, ROCKSLIP_MOUNT=str(shown)).stdout == "all\n"
    machine.install("python3", "exit 1")
    machine.install_debian()
    machine.in_env("true", ROCKSLIP_MOUNT=str(shown), ROCKSLIP_WAY="3")
    machine.install("id", "echo 1000")
    machine.install_engine("docker")
    machine.in_env("true", ROCKSLIP_MOUNT=str(shown), ROCKSLIP_WAY="2")
    lines = machine.log.read_text().splitlines()
    told = [line for line in lines if "ROCKSLIP_VISIBLE=" in line]
    assert len(told) == 2
    for line in told:
        folders = line.split("ROCKSLIP_VISIBLE=")[1]
        for folder in (REPOSITORY, machine.current, "/tmp", shown):
            assert f"{folder}" in folders


def test_a_link_to_the_script_finds_the_repository(machine: Machine) -> None:
    machine.install("python3")
    link = machine.folder / "link to in-env"
    link.symlink_to(REPOSITORY / "in-env")
    done = machine.in_env("sh", "-c", 'echo "$PYTHONPATH"', script=link)
    assert done.stdout == f"{REPOSITORY}\n"


def test_both_stages_of_the_image_set_the_same_variables() -> None:
    """A stage from scratch takes none over, so that they stand in the Dockerfile twice."""
    text = (REPOSITORY / "Dockerfile").read_text(encoding="utf-8")
    blocks = re.findall(r"^ENV (LANG=(?:.*\\\n)*.*)$", text, re.MULTILINE)
    assert len(blocks) == 2
    assert blocks[0].split() == blocks[1].split()


# ---------------------------------------------------------------- kernels

SAYS = ("sh", "-c", 'cat "$ROCKSLIP_KERNELS"')
BUILDING = "in-env: building the kernels: some 20 s, once\n"


def test_kernels_are_compiled_once(machine: Machine) -> None:
    machine.install("python3")
    first, second = machine.in_env(*SAYS), machine.in_env(*SAYS)
    assert (first.stdout, first.stderr) == ("library\n", BUILDING)
    assert (second.stdout, second.stderr) == ("library\n", "")
    assert len(machine.calls("g++ -std")) == 1
    assert machine.in_env("sh", "-c", 'echo "${LC_ALL-none}"').stdout == "none\n"
    newer = COMPILER.replace("g++ 14", "g++ 15")
    machine.install("g++", newer.format(first=":"))
    assert machine.in_env(*SAYS).stderr == BUILDING


def test_kernels_are_compiled_inside_the_environment(machine: Machine) -> None:
    machine.install_engine("docker")
    machine.in_env("true", ROCKSLIP_KERNELS="/own.so")
    (run,) = machine.calls("docker run")
    build = REPOSITORY / "solver/kernels/build.sh"
    assert f" ROCKSLIP_KERNELS=/own.so {build} --for /cache {machine.home}/.cache/" in run
    machine.install("docker", "exit 1")
    machine.install_debian()
    machine.in_env("true")
    assert f" {build} --for /cache " in machine.log.read_text().splitlines()[-1]
    assert machine.calls("g++") == []


def test_kernels_of_ones_own_are_taken(machine: Machine) -> None:
    machine.install("python3")
    own = machine.folder / "own.so"
    own.write_text("own")
    done = machine.in_env(*SAYS, ROCKSLIP_KERNELS=str(own))
    assert (done.stdout, done.stderr) == ("own", "")
    assert machine.calls("g++") == []


def test_two_at_once_compile_kernels_once(machine: Machine) -> None:
    machine.install("python3")
    # The compiler ends when the other one waits, or after a while.
    waits = f'for i in $(seq 100); do grep -q waiting "{machine.folder}/said" || sleep 0.05; done'
    machine.install_compiler(waits)
    for tool in ("grep", "seq"):
        (machine.bin / tool).symlink_to(str(shutil.which(tool)))
    with (machine.folder / "said").open("w") as said:
        both = [
            subprocess.Popen(
                [REPOSITORY / "in-env", *SAYS],
                cwd=machine.current,
                env=machine.environment({}),
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
            )
            for _ in range(2)
        ]
        assert [process.communicate(timeout=60)[0] for process in both] == ["library\n"] * 2
    assert sorted((machine.folder / "said").read_text().splitlines(keepends=True)) == [
        BUILDING,
        "in-env: waiting for another ./in-env that builds the kernels\n",
    ]
    assert len(machine.calls("g++ -std")) == 1


def test_kernels_that_cannot_be_compiled_end_the_call(machine: Machine) -> None:
    machine.install("python3")
    machine.install_compiler("echo broken >&2; exit 1")
    done = machine.in_env("sh", "-c", "echo ran")
    assert (done.returncode, done.stdout) == (4, "")
    failed = "in-env: the kernels could not be compiled: the reason stands above\n"
    assert done.stderr == f"{BUILDING}broken\n{failed}"
    kernels = machine.home / ".cache/rockslip/trixie/kernels"
    assert [file.name for file in kernels.iterdir()] == ["lock"]
    (machine.bin / "g++").unlink()
    done = machine.in_env("sh", "-c", "echo ran")
    assert (done.returncode, done.stdout) == (4, "")
    missing = "no compiler for the kernels: got g++; install g++, or let CXX name another"
    assert done.stderr == f"in-env: {missing}\n"


def test_a_folder_of_kernels_that_cannot_be_written_to_is_one_line(machine: Machine) -> None:
    machine.install("python3")
    cache = machine.folder / "cache"
    cache.mkdir()
    (cache / "kernels").touch()
    done = machine.in_env("true", ROCKSLIP_CACHE=str(cache))
    assert done.returncode == 4
    line = "cannot be made or written to: set ROCKSLIP_CACHE to a folder of your own"
    assert done.stderr == f"in-env: {cache}/kernels {line}\n"


def test_kernels_not_used_for_a_month_go(machine: Machine) -> None:
    machine.install("python3")
    kernels = machine.home / ".cache/rockslip/trixie/kernels"
    kernels.mkdir(parents=True)
    for name, days in (("old.so", 40), ("new.so", 20)):
        (kernels / name).touch()
        used = time.time() - days * 86400
        os.utime(kernels / name, (used, used))
    machine.in_env("true")
    left = {file.name for file in kernels.iterdir()}
    assert "old.so" not in left and "new.so" in left
    (made,) = (kernels / name for name in left - {"lock", "new.so"})
    os.utime(made, (0, 0))
    machine.in_env("true")
    assert made.stat().st_mtime > time.time() - 3600
