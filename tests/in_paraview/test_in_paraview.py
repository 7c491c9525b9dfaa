"""A real ParaView opens runs by their script: all times, names, places, and something to see.

`make paraview` makes the runs in the environment, and runs these tests where there is a pvpython.
"""

from __future__ import annotations

import csv
import json
import math
import os
import shutil
import subprocess
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from in_paraview.runs import RANKS, SCENES, folder_of, make

pytestmark = [
    pytest.mark.serial,
    pytest.mark.slow,
    pytest.mark.skipif(
        shutil.which("pvpython") is None,
        reason="no pvpython here; `make paraview` runs this in an image that has one",
    ),
]

HERE = Path(__file__).resolve().parent
MADE = HERE.parents[1] / "output" / "paraview"
BODIES = {"elastic": ["stone"], "rigid": ["stone", "upper-part"], "frame": ["stone", "frame"]}
WIDTH, HEIGHT = 0.25, 1.0


@pytest.fixture(scope="module")
def screen() -> Iterator[dict[str, str]]:
    """The variables of a process that draws: ParaView does so on an X server, of this module.

    Its number is its own: the end of another server of that number removes the socket. And it
    never starts anew: it would do so between the two connections that ParaView begins with.
    """
    reads, writes = os.pipe()
    display = f":{100 + os.getpid() % 60000}"
    command = ["Xvfb", display, "-noreset", "-displayfd", str(writes)]
    command += ["-screen", "0", "1280x1024x24"]
    with subprocess.Popen(command, pass_fds=[writes], stderr=subprocess.DEVNULL) as server:
        os.close(writes)
        assert os.read(reads, 16), "no X server"  # once it is ready
        yield {**os.environ, "DISPLAY": display}
        server.terminate()
    os.close(reads)


def run_of(name: str, ranks: int, folder: Path) -> Path:
    """The folder of a run: one that was made before, or it is made where that is possible."""
    made = MADE / folder_of(name, ranks)
    if (made / "summary.json").is_file():
        return made
    if find_spec("dolfinx") is None:
        pytest.skip(f"no run in {made}, and no dolfinx to make it: make paraview")
    return make(folder, name, ranks)


def pvpython(screen: dict[str, str], *words: object) -> None:
    """Run a script by ParaView's Python."""
    command = ["pvpython", *map(str, words)]
    done = subprocess.run(command, env=screen, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, (done.stdout + done.stderr)[:1000]
    assert "Traceback" not in done.stderr and " ERR|" not in done.stderr, done.stderr


def rectangle(row: dict[str, str]) -> list[float]:
    """Bounds of the stone by its centre and angle in the history, m: least x, y, greatest x, y."""
    x, y = float(row["stone.centre_x_m"]), float(row["stone.centre_y_m"])
    angle = float(row["stone.angle_rad"])
    c, s = abs(math.cos(angle)), abs(math.sin(angle))
    half_wide, half_high = (WIDTH * c + HEIGHT * s) / 2, (WIDTH * s + HEIGHT * c) / 2
    return [x - half_wide, y - half_high, x + half_wide, y + half_high]


@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("name", SCENES)
def test_a_run_in_paraview(name: str, ranks: int, tmp_path: Path, screen: dict[str, str]) -> None:
    folder = run_of(name, ranks, tmp_path)
    answer = folder.parent / f"{folder.name}.json"
    pvpython(screen, HERE / "look.py", folder, answer)
    said: dict[str, Any] = json.loads(answer.read_text())
    assert said["times"] == pytest.approx([0.01 * k for k in range(301)], abs=1e-9)
    with (folder / "history.csv").open() as stream:
        rows = {round(float(row["time_s"]), 6): row for row in csv.DictReader(stream)}
    for seen in said["seen"]:
        names = BODIES[name]
        assert list(seen["bounds"]) == [*names, "contacts"]
        low, high = seen["bounds"][names[0]]
        expected = rectangle(rows[round(seen["time"], 6)])
        assert [*low[:2], *high[:2]] == pytest.approx(expected, abs=1e-6)
    assert min(said["drawn"]) > 0.03
    assert said["differ"] > 0.003


def test_a_film(tmp_path: Path, screen: dict[str, str]) -> None:
    folder = run_of("rigid", 1, tmp_path)
    pvpython(screen, folder / "open_in_paraview.py", tmp_path / "film.avi")
    assert (tmp_path / "film.avi").stat().st_size > 100_000
