"""`rockslip check`: the meaning of a scene, without solving it.

The text of the first case below stands in check.txt, of the others the lines that differ; the
memory of linear solvers is left to their own tests. To write it anew and look at the difference:
`./in-env env ROCKSLIP_WRITE=1 python3 -m pytest tests/unit/test_check.py`.
"""

from __future__ import annotations

import math
import os
import sys
import types
from difflib import ndiff
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import SHORT_GRANITE

from rockslip import parse_scene
from solver.cli import main
from solver.run.describe import describe

Captured = pytest.CaptureFixture[str]

TEXTS = Path(__file__).resolve().with_name("check.txt")

PLATE = "width=2.0, height=0.1, young=2e11, poisson=0.3, mass_ratio=2.0"
SLAB = "kind='elastic', support='bottom', width=3.0, density=2000.0, young=2e8, poisson=0.2"
FRAME = (
    "foundation={kind='frame', deck={width=2.0, height=0.1}, column={width=0.1}, bays=3,"
    " storey=1.5, density=7850, young=2e11, poisson=0.3}"
)
RECORD = "kind='record', file='push.txt', dt=0.01"
WEAK = "motion={kind='half_sine', amplitude_g=0.05, duration=0.5, start=0.1}"
FRICTION = "contact.friction={static=0.7, dynamic=0.5, cohesion=10}"

CASES: dict[str, list[str]] = {
    "the paper's block": [],
    "damping by both constants": ["damping={mass=10, stiffness=1e-4}"],
    "no damping": ["damping.stiffness=0"],
    "triangles under a sine": [
        *("block.cell=triangle", "block.degree=2", "block.cells=[2, 3]", "block.tilt_deg=0"),
        *("motion={kind='sine', amplitude_g=0.4, period=0.5}", "contact.friction=0.2"),
    ],
    "a platform": [
        "foundation={kind='oscillator', mass_ratio=2.0, period=0.5, damping_ratio=0.05}",
        "block.tilt_deg=0",
    ],
    "a held plate": [f"foundation={{kind='elastic', {PLATE}}}"],
    "a held plate with a mesh": [f"foundation={{kind='elastic', {PLATE}, degree=2, meshed=true}}"],
    "a plate on rollers": [
        f"foundation={{kind='elastic', {PLATE}, support='rollers', period=0.5, damping_ratio=0.05}}"
    ],
    "a frame": [FRAME],
    "a slab": [f"foundation={{{SLAB}, height=1.0}}", WEAK],
    "a block of soil that sways": [f"foundation={{{SLAB}, height=6.0}}", WEAK],
    "hexahedra": ["dimension=3", "block.velocity=[0.1, 0, -1]"],
    "tetrahedra": ["dimension=3", "block.cell=tetrahedron", "block.cells=[1, 1, 1]"],
    "rigid in space": ["dimension=3", "block.model=rigid", FRICTION],
    "rigid without gravity": ["block.model=rigid", "gravity=0", FRICTION],
    "a centre of mass": ["block.model=rigid", "block.centre_of_mass=[0.02, 0.55]"],
    "a centre of mass in space": [
        *("dimension=3", "block.model=rigid", "block.centre_of_mass=[0.01, -0.03, 0.55]"),
    ],
    "an inertia on a platform": [
        *("block.model=rigid", "block.tilt_deg=0", "block.inertia=60", "gravity_tilt_deg=2"),
        *("foundation={kind='oscillator', mass_ratio=2.0, period=0.5}", "block.restitution=0.95"),
    ],
    "two records": [f"motion={{{RECORD}, vertical={{{RECORD}, scale=-0.5, start=0.0123}}}}"],
    "steps beside samples": [f"motion={{{RECORD}}}", "time.step=0.003"],
    "a table": ["motion={kind='table', file='table.csv'}"],
    "a rigid block that is held and pushed": [
        *("block.model=rigid", "block.tilt_deg=0", "time.step=0.01"),
        "link=[{name='wire', kind='lashing', between=['block', 'foundation'], at=[0.125, 1.0],"
        " to=[0.5, 0.0], stiffness=1e6, preload=1e3, yield=2e3}, {name='wax', kind='wax',"
        " between=['block', 'foundation'], at=[0.0, 0.0], stiffness=1e6, strength=5e3}]",
        "force=[{name='wind', on='block', face='right', pressure=500.0, ramp=[0.0, 1.0]}]",
    ],
    "a wavelet": ["motion={kind='ricker', amplitude_g=0.2, frequency=2}", "gravity=1.62"],
}
"""Overrides of the paper's block; the record is 1 m/s2 for 4 s, so that its measures are known."""

UPPER = """
[[block]]
name = "upper"
on = "block"
width = 0.25
height = 0.5
thickness = 0.75
mass = 100.0
model = "rigid"
friction = 0.2
"""
STACK = ["motion.vertical={kind='ricker', amplitude_g=-0.3, frequency=2.0}",
         "upper.angular_velocity=2"]  # fmt: skip


@pytest.fixture
def period(monkeypatch: pytest.MonkeyPatch) -> None:
    """A natural period of meshed foundations that no mesh is needed for."""
    module: Any = types.ModuleType("solver.build.foundation")
    module.natural_period = lambda scene: 0.25
    monkeypatch.setitem(sys.modules, "solver.build.foundation", module)


@pytest.mark.usefixtures("period")
def test_the_texts_are_those_of_the_page(granite: Path, capsys: Captured) -> None:
    """And nothing is written."""
    (granite.parent / "push.txt").write_text("units: m/s2\n" + "1\n" * 401)
    (granite.parent / "table.csv").write_text("1 0\n2 0.5\n4 0\n")
    (granite.parent / "stack.toml").write_text(
        SHORT_GRANITE.replace("[contact]", f"{UPPER}[contact]")
    )
    before = sorted(granite.parent.iterdir())
    found, first = "", list[str]()
    for name, words in (CASES | {"a stack": STACK}).items():
        scene = "stack.toml" if name == "a stack" else "granite.toml"
        assert main(["check", scene, *(["--set", *words] if words else [])]) == 0
        lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
        lines = [line for line in lines if not line.startswith("linear solver")]
        first = first or lines
        changed = [line for line in ndiff(first, lines) if line[0] in "+-"]
        found += "\n".join([f"# {name}", *(changed if words else lines), "\n"])
    assert sorted(granite.parent.iterdir()) == before
    if os.environ.get("ROCKSLIP_WRITE"):
        TEXTS.write_text(found)
    assert found == TEXTS.read_text()


@pytest.mark.serial
@pytest.mark.parametrize("dimension", [2, 3])
def test_check_counts_what_gmsh_makes_of_frames_and_tetrahedra(dimension: int) -> None:
    pytest.importorskip("dolfinx")
    from dolfinx.fem import functionspace

    from geometry.block import Block
    from geometry.foundation import Frame, Plate
    from geometry.frame_mesh import FrameCells, frame_mesh
    from geometry.mesh import block_mesh
    from rockslip import BlockSpec
    from solver.scene.foundation import ColumnSpec, DeckSpec, FrameCellsSpec, FrameSpec

    def text(mesh: Any, kind: str) -> str:
        count = mesh.topology.index_map(dimension).size_global
        nodes = functionspace(mesh, ("Lagrange", 2)).dofmap.index_map.size_global
        return f"{count} {kind} of degree 2, {nodes} nodes, {dimension * nodes} unknowns"

    bays = 2 if dimension == 2 else 1
    cells = {"bay": 3, "column": 1, "deck": 2, "storey": 4}
    spec = FrameSpec(
        deck=DeckSpec(width=2.0, height=0.1),
        column=ColumnSpec(width=0.1),
        bays=bays,
        storey=1.0,
        young=1.0,
        poisson=0.0,
        density=1.0,
        cells=FrameCellsSpec(**cells),
    )
    frame = Frame(
        deck=Plate(width=2.0, height=0.1, thickness=1.0), column_width=0.1, storey=1.0, bays=bays
    )
    made = frame_mesh(frame, dimension=dimension, cells=FrameCells(**cells)).mesh
    assert spec.mesh_size(dimension) == text(made, ("quadrilaterals", "hexahedra")[dimension - 2])
    counts: Any = (2, 3, 4)[:dimension]
    cell: Any = ("triangle", "tetrahedron")[dimension - 2]
    block = BlockSpec(
        width=1, height=1, density=1, young=1, poisson=0, cells=counts, cell=cell, degree=2
    ).in_dimension(2 if dimension == 2 else 3)
    shape = Block(width=1.0, height=1.0, thickness=1.0, density=1.0)
    made = block_mesh(shape, dimension=dimension, cells=counts, cell=cell, refinement=1.0).mesh
    assert str(block.mesh) == text(made, ("triangles", "tetrahedra")[dimension - 2])


def test_check_without_dolfinx_names_what_is_missing(
    granite: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "solver.build.foundation", None)
    assert main(["check", "granite.toml", "--set", FRAME]) == 4
    assert "natural period" in capsys.readouterr().err


def test_check_of_a_bad_record(granite: Path, capsys: Captured) -> None:
    """One line that names file and line, or the key; exit code 2."""
    file = granite.parent / "bad.AT2"
    file.write_text("A\nB\nUNITS OF G\nNPTS= 3, DT= .01\n1 2\n")
    words = ["check", "granite.toml", "--set", "motion={kind='record', file='bad.AT2'}"]
    assert main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.strip().endswith(
        f"{file}: line 5: got the end of the file after 2 values, allowed 3 values, as line 4 says"
    )
    file.write_text("A\nB\nUNITS OF G\nNPTS= 3, DT= .01\n1 2 3\n")
    vertical = "motion={vertical={kind='record', file='bad.AT2', dt=0.1}}"
    assert main(["check", "granite.toml", "--set", vertical]) == 2
    said = capsys.readouterr().err
    assert "motion.vertical.dt: got 0.1, allowed 0.01, as line 4 of " in said
    assert main(["check", "granite.toml", "--set", "motion={kind='record', file='.'}"]) == 2
    message = capsys.readouterr().err
    assert "motion.file: got " in message and "(a folder), allowed a file that exists" in message


@pytest.mark.parametrize("tilt", [5.0, -5.0])
def test_a_lean_between_the_axes_has_the_slenderness_of_its_corner(tilt: float) -> None:
    """Released at alpha in that direction a box stands with its centre above one corner."""
    text = (
        "dimension = 3\n[[block]]\nmodel = 'rigid'\nwidth = 0.4\nthickness = 0.3\n"
        "height = 1.2\nmass = 100.0\ntilt_direction_deg = 30.0\ntilt_deg = {}\n"
        "[time]\nend = 1.0\nstep = 1e-3\n"
    )
    told = describe(parse_scene(text.format(tilt)))
    assert f"released from {tilt:g} degrees towards 30 degrees from x" in told
    alpha = math.atan((0.2 * math.cos(math.pi / 6) + 0.15 * math.sin(math.pi / 6)) / 0.6)
    assert f"slenderness at 30 degrees {alpha:.5f} rad" in " ".join(told.split())
    scene = parse_scene(text.format(math.degrees(math.copysign(alpha, tilt))))
    (block,) = scene.blocks
    pose, centre = scene.poses()[block.name], np.array([[0.0, 0.0, 0.6]])
    corners = pose(np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.15, 0.15)]))
    lowest = corners[np.argmin(corners[:, 2])]
    along = (pose(centre)[0] - lowest)[:2] @ [math.cos(math.pi / 6), math.sin(math.pi / 6)]
    assert along == pytest.approx(0.0, abs=1e-12)
    assert "slenderness at" not in describe(parse_scene(text.format(0.0)))
