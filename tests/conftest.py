"""Fixtures and settings of all tests."""

import gc
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from scenes import SHORT_GRANITE

# The same examples in every run, none of them judged by its time. To look for new ones:
# pytest --hypothesis-profile=search tests/unit/test_scene.py
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=60)
settings.register_profile("search", deadline=None, database=None, max_examples=2000)
settings.load_profile("repeatable")

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def ranks_in_step() -> Iterator[None]:
    """Collect garbage and wait for the other ranks after each test.

    PETSc objects are destroyed collectively: left to the collector of each rank they are destroyed
    at different times. Ranks exist for tests that imported MPI only.
    """
    yield
    mpi = sys.modules.get("mpi4py.MPI")
    if mpi is not None and mpi.COMM_WORLD.size > 1:
        gc.collect()
        mpi.COMM_WORLD.Barrier()


@pytest.fixture(scope="session")
def records() -> Path:
    """The folder of recorded ground motions, which the repository does not hold itself."""
    folder = REPOSITORY.parent / "shared" / "records"
    if not folder.is_dir():
        pytest.skip(f"no recorded ground motions in {folder}")
    return folder


@pytest.fixture
def granite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The scene `SHORT_GRANITE` as a file in the current folder, and no mpirun around it."""
    for name in ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "granite.toml"
    file.write_text(SHORT_GRANITE)
    return file


@pytest.fixture
def falls_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs that a fall would end go on, for tests of the motion after it."""
    monkeypatch.setattr("solver.results.endings.Watch.look", lambda watch, rows: None)
