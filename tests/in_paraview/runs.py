"""Make the runs that ParaView is shown: python3 tests/in_paraview/runs.py FOLDER

An elastic block, a stack of rigid ones, and a block on a frame, serial and by two ranks.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
if str(TESTS) not in sys.path:
    sys.path.insert(0, str(TESTS))

from processes import outside_mpirun  # noqa: E402

#: So stiff that its corners are those of a rigid block to less than 1e-6 m.
STONE = """
[[block]]
name = "stone"
width = 0.25
height = 1.0
thickness = 0.75
mass = 503.0
tilt_deg = 3.0
"""
ELASTIC = "young = 1e12\npoisson = 0.2\ncells = [2, 6]\n"
RIGID = 'model = "rigid"\n'
UPPER = """
[[block]]
name = "upper-part"
on = "stone"
width = 0.2
height = 0.3
thickness = 0.75
mass = 100.0
model = "rigid"
"""
FRAME = """
[foundation]
kind = "frame"
storey = 1.0
deck = { width = 2.0, height = 0.3 }
column = { width = 0.1, young = 2e11 }
young = 3e10
poisson = 0.2
density = 2500.0
cells = { bay = 4, column = 1, deck = 1, storey = 2 }
"""
TIME = "\n[time]\nend = 3.0\nstep = 0.005\n"

SCENES = {
    "elastic": STONE + ELASTIC + TIME,
    "rigid": STONE + RIGID + UPPER + TIME,
    "frame": STONE + ELASTIC + FRAME + TIME,
}
RANKS = (1, 2)


def folder_of(name: str, ranks: int) -> str:
    """Name of the folder of a run."""
    return f"{name}-{ranks}"


def make(folder: Path, name: str, ranks: int) -> Path:
    """Run one of the scenes; returns its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / f"{name}.toml"
    scene.write_text(SCENES[name])
    made = folder / folder_of(name, ranks)
    command = [sys.executable, "-m", "solver", "run", str(scene), "-o", str(made), "-q", "--force"]
    launcher = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    subprocess.run([*launcher, *command], env=outside_mpirun(), check=True, cwd=TESTS.parent)
    return made


def main() -> None:
    """Make all of them."""
    folder = Path(sys.argv[1]).resolve()
    for name in SCENES:
        for ranks in RANKS:
            make(folder, name, ranks)


if __name__ == "__main__":
    main()
