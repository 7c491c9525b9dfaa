"""Options for PETSc on two ranks: one line and one exit code, or one output."""

from __future__ import annotations

from pathlib import Path

import pytest
from processes import on_ranks
from scenes import GRANITE


def run(folder: Path, words: str) -> tuple[int, str, list[str]]:
    """Exit code, output, and lines of the program itself of three steps on two ranks."""
    scene = GRANITE + "[time]\nend = 0.003\nstep = 0.001\n"
    (folder / "scene.toml").write_text(scene, encoding="utf-8")
    done = on_ranks(2, folder, "run", "scene.toml", "-q", "-o", "out", "--", *words.split())
    said = [line for line in done.stderr.splitlines() if line.startswith("rockslip")]
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout, said


@pytest.mark.mpi
def test_refused_in_one_line(tmp_path: Path) -> None:
    code, _, said = run(tmp_path, "-ksp_type gmres")
    assert code == 2
    assert len(said) == 1 and "no matrix is assembled for others" in said[0]


@pytest.mark.mpi
def test_outputs_come_once(tmp_path: Path) -> None:
    code, output, said = run(tmp_path, "-log_view -snes_view -snes_monitor")
    assert (code, said) == (0, [])
    assert output.count("PETSc Performance Summary") == 1
    assert output.count("type: newtonls") == 3
    assert output.count("  0 SNES Function norm") == 3
    assert output.count("There are no unused options") == 1
