"""What started this process, as the environment tells: a launcher such as mpirun, or ./in-env."""

from __future__ import annotations

import os
from pathlib import Path

#: What launchers set to the rank of a process.
VARIABLES = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID")


def _rank() -> int | None:
    """The rank that a launcher gave to this process; None without one."""
    for variable in VARIABLES:
        if os.environ.get(variable, "").isdigit():
            return int(os.environ[variable])
    return None


def was_launched() -> bool:
    """True if a launcher started this process, so that there may be other ranks."""
    return _rank() is not None


def launched_rank() -> int:
    """Rank of this process in what was launched; 0 for one that stands alone."""
    return _rank() or 0


#: What ./in-env sets to the folders that it shows to the command, where it does not show all.
VISIBLE = "ROCKSLIP_VISIBLE"


def hidden_by_in_env(path: Path) -> str:
    """Why ./in-env does not show a path to this process, as the predicate of a sentence.

    Empty where it does. What is written there goes into a layer that ends with the command.
    """
    shown = [Path(folder) for folder in os.environ.get(VISIBLE, "").split(":") if folder]
    places = {Path(os.path.abspath(path)), path.resolve()}
    if not shown or all(any(p.is_relative_to(folder) for folder in shown) for p in places):
        return ""
    place = path.resolve()
    if any(place.is_relative_to(folder) for folder in shown):
        place = Path(os.path.abspath(path))
    parent = place if place.parent == Path("/") else place.parent
    return f"is in no folder that ./in-env shows to the command; set ROCKSLIP_MOUNT={parent}"
