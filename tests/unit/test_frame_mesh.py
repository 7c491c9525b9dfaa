"""Frames: sizes, tags, that their parts hold together, and their sway stiffness."""

from mpi4py import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import LinearProblem
from dolfinx.mesh import exterior_facet_indices

from geometry.foundation import Frame, Plate
from geometry.frame_mesh import (
    FrameCells,
    alternate_counts,
    boxes_mesh,
    column_breaks,
    frame_mesh,
)
from geometry.gmsh_model import CELLS
from geometry.tags import FacetTag

COMM = MPI.COMM_WORLD
DECK = Plate(width=2.0, height=0.2, thickness=1.0)


def integral(form):
    return COMM.allreduce(fem.assemble_scalar(fem.form(form)))


def face_sizes(made):
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    one = fem.Constant(made.mesh, 1.0)
    return {tag: integral(one * ds(int(tag))) for tag in FacetTag}


@pytest.mark.parametrize("cell", CELLS[2])
@pytest.mark.parametrize("bays", [1, 3])
def test_portal(bays, cell):
    frame = Frame(deck=DECK, column_width=0.1, storey=1.5, bays=bays)
    cells = FrameCells(bay=5, column=2, deck=3, storey=7)
    made = frame_mesh(frame, cells=cells, cell=cell, comm=COMM)
    columns = bays + 1
    count = 3 * (5 * bays + 2 * columns) + 7 * 2 * columns
    assert made.mesh.basix_cell().name == cell
    assert made.mesh.topology.index_map(2).size_global == count * (2 if cell == "triangle" else 1)
    area = integral(fem.Constant(made.mesh, 1.0) * ufl.dx)
    assert area == pytest.approx(2.0 * 0.2 + columns * 0.1 * 1.5)
    sizes = face_sizes(made)
    assert sizes[FacetTag.TOP] == pytest.approx(2.0)
    assert sizes[FacetTag.FEET] == pytest.approx(columns * 0.1)
    assert sizes[FacetTag.BOTTOM] == pytest.approx(2.0 - columns * 0.1)
    assert sizes[FacetTag.RIGHT] == pytest.approx(0.2 + columns * 1.5)
    assert sizes[FacetTag.LEFT] == pytest.approx(0.2 + columns * 1.5)
    x = ufl.SpatialCoordinate(made.mesh)
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    assert integral(x[1] * ds(int(FacetTag.FEET))) == pytest.approx(-1.7 * columns * 0.1)
    assert integral(x[1] * ds(int(FacetTag.TOP))) == pytest.approx(0.0, abs=1e-15)
    assert integral(x[0] * ufl.dx) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("carries", [1, 3])
def test_boxes_of_two_storeys(carries):
    """Blocks stand on the deck that carries; the free part of the other one's top is no carrier."""
    lines = [column_breaks(2.0, 0.1, 1), np.array([-3.4, -1.9, -1.7, -0.2, 0.0])]
    counts = [alternate_counts(1, 5, 1), [4, 1, 4, 1]]
    boxes = [(x, y) for y in range(4) for x in range(3) if y % 2 or x != 1]
    made = boxes_mesh(lines, counts, boxes, carries=carries, comm=COMM)
    assert made.mesh.topology.index_map(2).size_global == 2 * (7 + 2 * 4)
    sizes = face_sizes(made)
    top = {1: 1.8, 3: 2.0}
    assert sizes[FacetTag.TOP] == pytest.approx(top[carries])
    assert sizes[FacetTag.FREE] == pytest.approx(top[4 - carries])
    assert sizes[FacetTag.FEET] == pytest.approx(0.2)
    assert sizes[FacetTag.BOTTOM] == pytest.approx(2 * 1.8)


def test_boxes_of_unknown_cells_are_refused():
    with pytest.raises(ValueError, match="boxes_mesh: got cell 'hexagon'"):
        boxes_mesh([np.arange(2.0)] * 2, [[1], [1]], [(0, 0)], carries=0, cell="hexagon")


@pytest.mark.parametrize("cell", CELLS[3])
def test_deck_on_four_columns(cell):
    frame = Frame(deck=DECK, column_width=0.1, column_thickness=0.2, storey=1.5)
    cells = FrameCells(bay=4, bay_across=3, column=1, deck=2, storey=5)
    made = frame_mesh(frame, dimension=3, cells=cells, cell=cell, comm=COMM)
    assert made.mesh.basix_cell().name == cell
    count = 2 * 6 * 5 + 4 * 5
    assert made.mesh.topology.index_map(3).size_global == count * (5 if "tet" in cell else 1)
    volume = integral(fem.Constant(made.mesh, 1.0) * ufl.dx)
    assert volume == pytest.approx(2.0 * 0.2 + 4 * 0.1 * 0.2 * 1.5)
    sizes = face_sizes(made)
    assert sizes[FacetTag.TOP] == pytest.approx(2.0)
    assert sizes[FacetTag.FEET] == pytest.approx(4 * 0.02)
    assert sizes[FacetTag.BOTTOM] == pytest.approx(2.0 - 4 * 0.02)
    assert sizes[FacetTag.RIGHT] == pytest.approx(0.2 + 4 * 0.2 * 1.5)
    assert sizes[FacetTag.LEFT] == pytest.approx(0.2 + 4 * 0.2 * 1.5)
    assert sizes[FacetTag.BACK] == pytest.approx(0.4 + 4 * 0.1 * 1.5)
    assert sizes[FacetTag.FRONT] == pytest.approx(0.4 + 4 * 0.1 * 1.5)
    made.mesh.topology.create_connectivity(2, 3)
    assert set(exterior_facet_indices(made.mesh.topology)) <= set(made.facet_tags.indices)


@pytest.mark.parametrize("dimension", [2, 3])
def test_sways_as_columns_between_clamped_ends(dimension):
    """k = n 12 E I/h^3 for columns between feet and a rigid deck, less their flexible ends."""
    young, force, width = 1.0e9, 1.0e3, 0.1
    deck = Plate(width=1.0, height=0.3, thickness=0.6)
    frame = Frame(deck=deck, column_width=width, storey=2.0)
    cells = FrameCells(bay=4, column=2, deck=3, storey=16)
    made = frame_mesh(frame, dimension=dimension, cells=cells, comm=COMM)
    V = fem.functionspace(made.mesh, ("Lagrange", 2, (dimension,)))
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    strain = ufl.sym(ufl.grad(u))  # Poisson's ratio 0: S = E strain
    feet = fem.locate_dofs_topological(V, dimension - 1, made.facet_tags.find(FacetTag.FEET))
    held = fem.dirichletbc(np.zeros(dimension), feet, V)
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)(int(FacetTag.TOP))
    top = 1.0 if dimension == 2 else 0.6
    problem = LinearProblem(
        young * ufl.inner(strain, ufl.grad(v)) * ufl.dx,
        fem.Constant(made.mesh, force / top) * v[0] * ds,
        bcs=[held],
        petsc_options={"ksp_type": "preonly", "pc_type": "lu"},
        **_prefix(),
    )
    sway = integral(problem.solve()[0] * ds) / top
    depth, count = (1.0, 2) if dimension == 2 else (width, 4)
    inertia = depth * width**3 / 12
    stiffness = count * 12 * young * inertia / 2.0**3
    assert force / sway == pytest.approx(stiffness, rel=0.1)


def _prefix():
    """The options prefix, which dolfinx 0.9 does not take and later ones need."""
    import inspect

    needed = "petsc_options_prefix" in inspect.signature(LinearProblem.__init__).parameters
    return {"petsc_options_prefix": "sway_"} if needed else {}


def test_refuses_what_is_no_frame():
    with pytest.raises(ValueError, match="no bay"):
        Frame(deck=DECK, column_width=0.5, storey=1.0, bays=3)
    with pytest.raises(ValueError, match=r"Frame.storey: got -1.0"):
        Frame(deck=DECK, column_width=0.1, storey=-1.0)
    with pytest.raises(ValueError, match=r"Frame.bays: got 0"):
        Frame(deck=DECK, column_width=0.1, storey=1.0, bays=0)
    with pytest.raises(ValueError, match="column_thickness"):
        Frame(deck=DECK, column_width=0.1, storey=1.0, column_thickness=0.5)
    with pytest.raises(ValueError, match=r"FrameCells.deck: got 0"):
        FrameCells(deck=0)
    with pytest.raises(ValueError, match="with 2 bays"):
        frame_mesh(Frame(deck=DECK, column_width=0.1, storey=1.0, bays=2), dimension=3, comm=COMM)
    portal = Frame(deck=DECK, column_width=0.1, storey=1.0)
    with pytest.raises(ValueError, match="cell 'hexahedron'"):
        frame_mesh(portal, cell="hexahedron", comm=COMM)
    narrow = Frame(deck=Plate(width=2.0, height=0.2, thickness=0.2), column_width=0.1, storey=1.0)
    with pytest.raises(ValueError, match="do not fit"):
        frame_mesh(narrow, dimension=3, comm=COMM)
