"""Options for PETSc: which work, and which are refused in one line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from processes import outside_mpirun
from scenes import GRANITE

from solver.errors import SceneError
from solver.stepping.petsc_options import parse_options

pytestmark = pytest.mark.serial


def run(folder: Path, *words: str, model: str = "elastic") -> subprocess.CompletedProcess[str]:
    """Three steps with options for PETSc."""
    pytest.importorskip("dolfinx")
    (folder / "scene.toml").write_text(GRANITE + "[time]\nend = 0.003\nstep = 0.001\n")
    command = [sys.executable, "-m", "solver", "run", "scene.toml", "-q", "--force"]
    command += ["--set", f'block.model="{model}"', "--", *words]
    return subprocess.run(
        command, cwd=folder, env=outside_mpirun(), capture_output=True, text=True, timeout=300
    )


@pytest.mark.parametrize(
    ("words", "said", "count"),
    [
        ("-rockslip_snes_monitor", "SNES Function norm", None),
        ("-snes_monitor", "SNES Function norm", None),
        ("-snes_view", "type: newtonls", 3),
        ("-rockslip_snes_converged_reason", "solve converged due to", 3),
        ("-rockslip_snes_linesearch_type l2", "", None),
        ("-log_view", "PETSc Performance Summary", 1),
        ("-log_view -snes_view", "type: newtonls", 3),
        ("-options_left", "There are no unused options.", None),
        ("-malloc_debug", "", None),
        ("-info", "PetscInitialize", None),
        ("-snes_converged_reason -rockslip_snes_linesearch_type cp", "solve converged due to", 3),
    ],
)
def test_these_work(tmp_path: Path, words: str, said: str, count: int | None) -> None:
    done = run(tmp_path, *words.split())
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert count is None or done.stdout.count(said) == count
    assert "not used" not in done.stdout + done.stderr


@pytest.mark.parametrize("model", ["elastic", "rigid"])
@pytest.mark.parametrize(
    ("words", "parts"),
    [
        ("-rockslip_snes_mointor", ["-rockslip_snes_mointor", "mean '-rockslip_snes_monitor'?"]),
        ("-rockslip_what 3", ["-rockslip_what", "an option of PETSc's SNES, KSP or PC"]),
        ("-rockslip_snes_max_it three", ["snes_max_it three", "values for PETSc"]),
        ("-log_veiw", ["-log_veiw", "did you mean '-log_view'?"]),
    ],
)
def test_unknown_ones_are_refused_before_anything_is_written(
    tmp_path: Path, words: str, parts: list[str], model: str
) -> None:
    done = run(tmp_path, *words.split(), model=model)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    for part in parts:
        assert part in done.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize(
    "words",
    [
        "-snes_linesearch_type bt",
        "-rockslip_snes_linesearch_type bt",
        "-snes_type newtontr",
        "-snes_type ngmres",
        "-ksp_type gmres",
        "-pc_type lu",
        "-snes_fd",
        "-rockslip_snes_mf",
        "-snes_mf_operator",
        "-snes_type",
    ],
)
def test_those_that_need_a_matrix_are_refused(words: str) -> None:
    with pytest.raises(SceneError, match="for a matrix, and none is assembled") as caught:
        parse_options(words.split())
    assert len(str(caught.value)) <= 200
    assert words.split()[0].replace("rockslip_", "") in str(caught.value)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("-ksp_view_final_residual", "multiply by the Jacobian, and none is assembled"),
        ("-ksp_diagonal_scale", "values for PETSc"),
    ],
)
def test_those_that_ask_for_products_all_the_same_end_the_run(
    tmp_path: Path, words: str, said: str
) -> None:
    """In one line, from the first step."""
    done = run(tmp_path, *words.split())
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert said in done.stderr and words in done.stderr


def test_without_a_mesh_the_others_are_of_no_use(tmp_path: Path) -> None:
    done = run(tmp_path, "-rockslip_snes_monitor", "-log_view", model="rigid")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_without_a_mesh_a_reader_may_go_away(tmp_path: Path) -> None:
    """PETSc, which checks the options, does not end the run where a pipe is closed."""
    run(tmp_path, model="rigid")
    words = f"{sys.executable} -m solver run scene.toml --force -- -rockslip_snes_monitor"
    piped = ["bash", "-o", "pipefail", "-c", f"{words} | true"]
    done = subprocess.run(
        piped, cwd=tmp_path, env=outside_mpirun(), capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, "PETSC ERROR" in done.stderr) == (0, False), done.stderr


def test_own_options_keep_their_values() -> None:
    options = parse_options(["-log_view", ":file.txt", "-snes_max_it", "-3", "-info"])
    assert options.own_words() == ["-log_view", ":file.txt", "-info"]
    assert options.solver == {"rockslip_snes_max_it": "-3"}
