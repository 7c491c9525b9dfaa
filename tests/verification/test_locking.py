"""Nearly incompressible blocks: degree 1 locks, degree 2 does not (docs/stability.md)."""

import pytest

from solver.meshed_run import MeshedRun
from solver.scene import parse_scene


def compliance(**changes: object) -> float:
    """Strain energy of a block glued to an incline of 10 degrees, J: half the work of its load."""
    block = {"width": 0.25, "height": 1.0, "thickness": 0.75, "density": 2680.0, "young": 1e9}
    scene = {
        "block": [{**block, **changes}],
        "gravity_tilt_deg": 10.0,
        "contact": {"friction": 1000.0},
        "time": {"end": 1e-3, "step": 1e-3},
    }
    return MeshedRun(parse_scene(scene), lambda line: None).state.strain


def test_locking() -> None:
    """Over that of a finer mesh, at nu 0.4999: the numbers of the docs."""
    fine = compliance(poisson=0.4999, degree=2, cells=[12, 40])
    for cell, degree, share in (
        ("quadrilateral", 1, 0.144),
        ("quadrilateral", 2, 0.916),
        ("triangle", 2, 0.965),
    ):
        coarse = compliance(poisson=0.4999, cell=cell, degree=degree, cells=[4, 10])
        assert coarse / fine == pytest.approx(share, abs=0.01)
