"""Options for PETSc: which work, and which are refused in one line."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from processes import python
from scenes import GRANITE

from solver.errors import SceneError
from solver.stepping.petsc_options import command_line, parse_options

pytestmark = pytest.mark.serial


def run(folder: Path, *words: str, model: str = "elastic") -> subprocess.CompletedProcess[str]:
    """Three steps with options for PETSc."""
    pytest.importorskip("dolfinx")
    (folder / "scene.toml").write_text(GRANITE + "[time]\nend = 0.003\nstep = 0.001\n")
    command = ["-m", "solver", "run", "scene.toml", "-q", "--force"]
    command += ["--set", f'block.model="{model}"', "--", *words]
    return python(*command, folder=folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "said", "count"),
    [
        ("-snes_monitor", "SNES Function norm", None),
        ("-log_view -snes_view", "type: newtonls", 3),
        ("-snes_converged_reason -rockslip_snes_linesearch_type cp", "solve converged due to", 3),
        ("-rockslip_snes_mointor", "Option left: name:-rockslip_snes_mointor (no value)", 1),
        ("-log_veiw", "Option left: name:-log_veiw (no value)", 1),
    ],
)
def test_taken_or_said_to_be_unknown_by_petsc(
    tmp_path: Path, words: str, said: str, count: int | None
) -> None:
    done = run(tmp_path, *words.split())
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert count is None or done.stdout.count(said) == count
    assert ("could be spelling mistake" in done.stdout) == ("Option left" in said)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "part"),
    [
        ("-rockslip_snes_max_it three", "three has no integer value"),
        ("-snes_type ngmres", "no matrix is assembled for others"),
        ("-rockslip_snes_mf", "no matrix is assembled for others"),
        ("-snes_linesearch_type bt", "those that multiply by no matrix"),
        ("-ksp_diagonal_scale", "those that multiply by no matrix"),
    ],
)
def test_other_methods_and_values_are_refused_in_one_line(
    tmp_path: Path, words: str, part: str
) -> None:
    done = run(tmp_path, *words.split())
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    given = words if "rockslip" in words else words.replace("-", "-rockslip_", 1)
    assert f"got {given}, allowed" in done.stderr and part in done.stderr
    if "matrix is" in part or "value" in part:  # before anything is written
        assert [file.name for file in tmp_path.iterdir()] == ["scene.toml"]


def test_without_a_mesh_they_are_of_no_use(tmp_path: Path) -> None:
    done = run(tmp_path, "-rockslip_snes_monitor", "-log_view", model="rigid")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_words() -> None:
    words = ["-log_view", ":file.txt", "-snes_max_it", "-3", "-info"]
    options = parse_options(words)
    assert options == {"log_view": ":file.txt", "rockslip_snes_max_it": "-3", "info": None}
    assert command_line(options)[2:4] == ["-rockslip_snes_max_it", "-3"]
    with pytest.raises(SceneError, match="options after --: got 5"):
        parse_options(["-info", "4", "5"])
