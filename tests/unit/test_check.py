"""`rockslip check`: what a scene means, without solving it."""

from __future__ import annotations

import sys
import types
from pathlib import Path
from typing import Any

import pytest
from scenes import SHORT_GRANITE

from solver.cli import main

Captured = pytest.CaptureFixture[str]


def test_check_tells_the_numbers_of_the_paper_s_block(granite: Path, capsys: Captured) -> None:
    """R, alpha, p and e from B and H by hand (Housner 1963)."""
    assert main(["check", "granite.toml"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    for part in (
        "mass 503 kg",
        "R 0.5154 m",
        "alpha 0.24498 rad = 14.036 degrees",
        "p 3.7783 1/s",
        "uplift at 0.2500 g",
        "restitution 0.9118",
        "damping beta_R 3.74e-05 s: 2 % of critical at 170 Hz, its first bending mode",
        "steady sliding does not flutter up to friction 1",
        "expected mode rock",
        "96 quadrilaterals of degree 1, 119 nodes, 238 unknowns",
        "300 steps of 0.001 s",
    ):
        assert part in text
    assert list(granite.parent.iterdir()) == [granite]


def test_check_tells_the_damping_that_is_given(granite: Path, capsys: Captured) -> None:
    assert main(["check", "granite.toml", "--set", "damping={mass=10, stiffness=1e-4}"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "damping lambda_R 10 1/s, beta_R 0.0001 s: 5.8 % of critical at 170 Hz" in text
    assert main(["check", "granite.toml", "--set", "damping.stiffness=0"]) == 0
    assert "damping none" in " ".join(capsys.readouterr().out.split())
    assert main(["check", "granite.toml", "--set", "block.model='rigid'"]) == 0
    assert "damping" not in capsys.readouterr().out


def test_check_counts_other_meshes_and_motions(granite: Path, capsys: Captured) -> None:
    words = ["block.cell=triangle", "block.degree=2", "block.cells=[2, 3]", "block.tilt_deg=0"]
    motion = ["motion={kind='sine', amplitude_g=0.4, period=0.5}", "contact.friction=0.2"]
    assert main(["check", "granite.toml", "--set", *words, "--set", *motion]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "12 triangles of degree 2, 35 nodes, 70 unknowns" in text
    assert "peak 0.4 g = 3.924 m/s2" in text
    assert "expected mode slide (" in text


PLATE = [
    "foundation={kind='elastic', width=2.0, height=0.1, young=2e11, poisson=0.3, mass_ratio=2.0,"
    " support='rollers', period=0.5, damping_ratio=0.05}"
]
FRAME = [
    "foundation={kind='frame', deck={width=2.0, height=0.1}, column={width=0.1}, bays=3,"
    " storey=1.5, density=7850, young=2e11, poisson=0.3}"
]


def checked(captured: Captured, *words: str) -> str:
    """What `rockslip check` says, blanks made one."""
    assert main(["check", "granite.toml", "--set", *words]) == 0
    return " ".join(captured.readouterr().out.split())


def test_check_tells_of_a_platform(granite: Path, capsys: Captured) -> None:
    words = "foundation={kind='oscillator', mass_ratio=2.0, period=0.5, damping_ratio=0.05}"
    text = checked(capsys, words, "block.tilt_deg=0")
    for part in (
        "foundation rigid platform on a spring mass 251.5 kg (blocks / platform 2)",
        "stiffness 39715.3 N/m",
        "damping 316.044 N s/m, 5 % of critical",
        "natural period 0.5 s (empty, rigid)",
    ):
        assert part in text
    assert "expected mode" not in text


def test_check_tells_whether_a_held_plate_is_meshed(granite: Path, capsys: Captured) -> None:
    plate = "kind='elastic', width=2.0, height=0.1, young=2e11, poisson=0.3, mass_ratio=2.0"
    text = checked(capsys, f"foundation={{{plate}}}")
    assert "plate, 2 x 0.1 x 0.75 m, held everywhere: a rigid face with ends" in text
    assert "quadrilaterals of degree 1, 125" not in text
    text = checked(capsys, f"foundation={{{plate}, degree=2, meshed=true}}")
    assert "meshed plate, 2 x 0.1 x 0.75 m, held everywhere density 1676.67 kg/m3" in text
    assert "mesh 96 quadrilaterals of degree 1, 125 nodes, all of them held" in text


def test_check_reports_the_period_of_meshed_foundations(
    granite: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    module: Any = types.ModuleType("solver.build.foundation")
    module.natural_period = lambda asked: 0.25 if asked.foundation.kind == "frame" else 0.51
    monkeypatch.setitem(sys.modules, "solver.build.foundation", module)
    text = checked(capsys, *PLATE)
    assert "meshed plate, 2 x 0.1 x 0.75 m, on rollers density 1676.67 kg/m3" in text
    assert "mesh 96 quadrilaterals of degree 1, 125 nodes, 250 unknowns" in text
    assert "natural period 0.5 s (empty, rigid) natural period 0.51 s (empty, of the mesh)" in text
    text = checked(capsys, *FRAME)
    assert "meshed frame, deck 2 x 0.1 x 0.75 m columns 4, 0.1 x 0.75 m, 1.5 m high" in text
    assert "natural period 0.25 s (empty, of the mesh)" in text


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
    )
    shape = Block(width=1.0, height=1.0, thickness=1.0, density=1.0)
    made = block_mesh(shape, dimension=dimension, cells=counts, cell=cell, refinement=1.0).mesh
    assert block.mesh_size(dimension) == text(made, ("triangles", "tetrahedra")[dimension - 2])


def test_check_without_dolfinx_says_what_is_missing(
    granite: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "solver.build.foundation", None)
    assert main(["check", "granite.toml", "--set", *FRAME]) == 4
    assert "natural period" in capsys.readouterr().err


def test_check_in_space_and_of_rigid_blocks(granite: Path, capsys: Captured) -> None:
    text = checked(capsys, "dimension=3", "block.velocity=[0.1, 0, -1]")
    assert "slenderness along y 0.64350 rad" in text
    assert "velocity 0.1 0 -1 m/s" in text
    assert "576 hexahedra of degree 1, 833 nodes, 2499 unknowns" in text
    text = checked(capsys, "dimension=3", "block.cell=tetrahedron", "block.cells=[1, 1, 1]")
    assert "5 tetrahedra of degree 1, 8 nodes" in text
    words = ("block.model=rigid", "contact.friction={static=0.7, dynamic=0.5, cohesion=10}")
    text = checked(capsys, "dimension=3", *words)
    assert "mesh none: rigid, 6 unknowns" in text
    assert "friction 0.7 static, 0.5 dynamic, a jump, cohesion 10 Pa" in text
    assert "mesh none: rigid, 3 unknowns" in checked(capsys, *words)


def test_check_of_a_stack_with_motions(granite: Path, capsys: Captured) -> None:
    upper = """
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
    granite.write_text(SHORT_GRANITE.replace("[contact]", f"{upper}[contact]"))
    heave = "motion.vertical={kind='ricker', amplitude_g=-0.3, frequency=2.0}"
    text = checked(capsys, heave, "upper.angular_velocity=2")
    for part in (
        "upper 0.25 x 0.5 x 0.75 m, on block",
        "angular velocity 2 rad/s",
        "friction of block 0.7 friction of upper 0.2",
        "base motion none vertical peak 0.3 g = 2.943 m/s2",
        "mesh of upper none: rigid",
    ):
        assert part in text
    assert "expected mode" not in text
    assert "frequency p" not in checked(capsys, "gravity=0")


def test_check_of_a_record(granite: Path, capsys: Captured) -> None:
    """1 m/s2 for 4 s: its measures are known."""
    (granite.parent / "push.txt").write_text("units: m/s2\n" + "1\n" * 401)
    record = "kind='record', file='push.txt', dt=0.01"
    text = checked(capsys, f"motion={{{record}, vertical={{{record}, scale=-0.5, start=0.0123}}}}")
    for part in (
        "base motion PGA 0.1019 g = 1 m/s2 read as columns: 401 samples, 0.01 s apart (motion.dt), "
        "in m/s2 (line 1) samples 401, 0.01 s apart, 4 s long, from 0 s",
        "PGV 4.0000 m/s PGD 8.0000 m duration D5-95 3.60 s Arias intensity 0.6405 m/s",
        "PSA in g, 5 % 0.1 s 0.1890, 0.2 s 0.1890, 0.5 s 0.1890, 1 s 0.1890, 2 s 0.1890, 4 s 0.18",
        "steps 0.001 s divides 0.01 s: 10 between two samples",
        "in m/s2 (line 1), times -0.5 (scale) samples 401, 0.01 s apart, 4 s long, from 0.0123 s",
        "PGV 2.0000 m/s PGD 4.0000 m duration D5-95 3.60 s Arias intensity 0.1601 m/s",
        "steps the first sample, at 0.0123 s, is inside one: they take the mean acceleration",
    ):
        assert part in text
    text = checked(capsys, f"motion={{{record}}}", "time.step=0.003")
    assert "steps 0.003 s does not divide 0.01 s: they take the mean acceleration" in text


def test_check_of_tables_and_pulses(granite: Path, capsys: Captured) -> None:
    (granite.parent / "table.csv").write_text("1 0\n2 0.5\n4 0\n")
    text = checked(capsys, "motion={kind='table', file='table.csv'}")
    for part in (
        "PGA 0.5 g = 4.905 m/s2 read as columns: 3 samples, in g (default of tables) samples 3, "
        "1 to 2 s apart, 3 s long, from 1 s",
        "PGV 7.3575 m/s",
        "PGD 12.2625 m",
        "PSA in g, 5 % 0.1 s 0.50",
        "steps not those of the samples: they take the mean acceleration, no sample is skipped",
    ):
        assert part in text
    text = checked(capsys, "motion={kind='half_sine', amplitude_g=0.2, duration=0.5, start=0.1}")
    assert "span 0.1 to 0.6 s velocity up to 0.6245 m/s, 0.6245 m/s in the end" in text
    text = checked(capsys, "motion={kind='ricker', amplitude_g=0.2, frequency=2}", "gravity=1.62")
    assert "peak 0.2 g = 1.962 m/s2 span 0 to 1.5 s" in text
    assert ", 0 m/s in the end" in text


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


@pytest.mark.parametrize(
    ("carrier", "words"),
    [
        ("", "restitution 0.9118 (Housner 1963)"),
        # (R8): kappa = 2/3, h^2 (4/3 - kappa) = 1/6, b^2 = 1/64
        (
            "foundation={kind='oscillator', mass_ratio=2.0, period=0.4}",
            "restitution 0.8333 (on a platform of this mass, (R8) of docs/reference.md)",
        ),
        (
            "foundation={kind='elastic', width=2.0, height=0.2, density=2400, young=3e10, "
            "poisson=0.2, support='bottom'}",
            "restitution 0.9118 (Housner 1963, on firm ground)",
        ),
    ],
)
def test_check_tells_the_restitution_on_what_carries_the_block(
    granite: Path, capsys: Captured, carrier: str, words: str
) -> None:
    arguments = ["check", "granite.toml", *(["--set", carrier] if carrier else [])]
    assert main(arguments) == 0
    assert words in " ".join(capsys.readouterr().out.split())


def test_no_mode_is_expected_on_a_foundation_that_sways(granite: Path, capsys: Captured) -> None:
    """A meshed one that is higher than wide; a slab is firm ground."""
    slab = "kind='elastic', support='bottom', width=3.0, density=2000.0, young=2e8, poisson=0.2"
    motion = "motion={kind='half_sine', amplitude_g=0.05, duration=0.5}"
    for height, expected in ((1.0, True), (6.0, False)):
        text = checked(capsys, f"foundation={{{slab}, height={height}}}", motion)
        assert ("expected mode" in text) == expected
