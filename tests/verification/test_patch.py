"""Patch test of contact (Taylor and Papadopoulos 1991): uniform pressure, non-matching meshes.

A punch on a foundation under uniform pressure has uniform stress, and so must have what it is
computed by. It has on the common refinement of both surfaces (`cuts`), and there alone.
"""

from dataclasses import dataclass

from mpi4py import MPI

import basix
import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import compute_midpoints
from loads import surface_force
from refinement import cut_by, outlines

from benchmarks.verification.fixed_pair import FixedPair, faces_on
from benchmarks.verification.load_steps import contact_tractions, nodal_pressure
from geometry.block import Block
from geometry.foundation import Plate
from geometry.mesh import block_mesh, move, plate_mesh
from geometry.tags import FacetTag
from rockslip import parse_scene
from solver.bodies.elastic_body import ElasticBody, Support
from solver.bodies.elastic_forms import green_strain
from solver.build.assembly import build, initial_state
from solver.contact.body_points import NodePoints
from solver.contact.carriers import Face
from solver.contact.facets import carrier_surface
from solver.scene import FrictionSpec
from solver.scene.material import Material
from solver.scheme.generalized_alpha import GeneralizedAlpha
from solver.stepping.stepper import Stepper
from solver.stepping.system import System

pytestmark = pytest.mark.serial

PRESSURE = 1e-6
"""Over Young's modulus: what is not uniform is not large deformation."""
SLOPE = np.radians(17.0)
UNIFORM = 1e-8


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A punch of width 1 (or less) and height 1 on a foundation, 1 wide and 1/2 high."""

    dimension: int = 2
    cell: str | None = None
    degree: int = 1
    slope: float = 0.0
    young: tuple[float, float] = (1.0, 1.0)
    poisson: float = 0.3
    friction: float = 0.0
    width: float = 1.0
    points: str = "gauss"
    cuts: bool = True

    @property
    def frame(self) -> np.ndarray:
        """Rows normal and tangents of the interface."""
        unit, d = np.eye(self.dimension), self.dimension
        c, s = np.cos(self.slope), np.sin(self.slope)
        turn = unit.copy()
        turn[np.ix_([0, d - 1], [0, d - 1])] = [[c, s], [-s, c]]
        return np.vstack([unit[-1], unit[:-1]]) @ turn.T

    def turned(self, x: np.ndarray) -> np.ndarray:
        return np.roll(x, 1, axis=1) @ self.frame

    def body(self, made, number: int, supports=()) -> ElasticBody:
        plane = "strain" if self.dimension == 2 else "solid"
        material = Material(
            young=self.young[number], poisson=self.poisson, density=1.0, plane=plane
        )
        return ElasticBody(made.mesh, material, degree=self.degree, supports=supports)

    def errors(self) -> tuple[float, float, float]:
        """Largest relative errors of nodal pressure, of single points', and of the stress."""
        d, space = self.dimension, self.dimension == 3
        block = Block(width=self.width, height=1.0, thickness=1.0, density=1.0)
        plate = Plate(width=1.0, height=0.5, thickness=1.0)
        kind = {"dimension": d, "cell": self.cell, "comm": MPI.COMM_SELF}
        upper = block_mesh(block, cells=(3, 2, 2) if space else (4, 3), **kind)
        lower = plate_mesh(plate, cells=(2, 3, 1) if space else (5, 2), **kind)
        for made in (upper, lower):
            move(made.mesh, self.turned)
        # Level on rollers; sloped all of the bottom is held, which nu = 0 does not feel.
        held = range(d) if self.slope else (d - 1,)
        bottom = Support(facets=lower.facet_tags.find(FacetTag.BOTTOM), directions=tuple(held))
        bodies = self.body(upper, 0), self.body(lower, 1, [bottom])
        surface = carrier_surface(bodies[1].space, lower.facet_tags, int(FacetTag.TOP))
        nodes = NodePoints(bodies[1], surface.layer, surface.positions)
        face = Face(nodes, surface.nodes, self.frame, surface.cell, surface.degree)
        contact = faces_on(
            bodies[0],
            upper.facet_tags,
            face,
            FrictionSpec(static=self.friction),
            points=self.points,
            cut=cut_by(outlines(surface)) if self.cuts else None,
        )
        stepper = Stepper(
            System(bodies), [FixedPair(contact, on=1)], GeneralizedAlpha(0.8), gravity=np.zeros(d)
        )
        loaded = upper.facet_tags.find(FacetTag.TOP), beside(lower, self.width)
        load = [
            surface_force(body, facets, -PRESSURE * self.frame[0])
            for body, facets in zip(bodies, loaded, strict=True)
        ]
        state = stepper.static_start(
            np.zeros(stepper.system.size), load=np.concatenate(load), steady=1e-5
        )
        link, memory = stepper.links[0], state.contacts[0]
        stresses = [
            -normal_stress(body, state.u[own], self.frame[0])
            for body, own in zip(bodies, stepper.system.slices, strict=True)
        ]
        found = nodal_pressure(link, memory), contact_tractions(link, memory).pressure
        assert memory.force[:, 0].sum() == pytest.approx(PRESSURE * self.width, rel=1e-8)
        return tuple(
            float(np.max(np.abs(values / PRESSURE - 1)))
            for values in (*found, np.concatenate(stresses))
        )


def beside(made, width: float) -> np.ndarray:
    """Facets of the top of a level foundation that a punch leaves free."""
    facets = made.facet_tags.find(FacetTag.TOP)
    if width == 1.0:
        return facets[:0]
    made.mesh.topology.create_connectivity(1, 2)
    ends = fem.functionspace(made.mesh, ("Lagrange", 1))
    places = ends.tabulate_dof_coordinates()[:, 0]
    middles = [
        places[fem.locate_dofs_topological(ends, 1, np.array([facet]))].mean() for facet in facets
    ]
    return facets[np.abs(middles) > width / 2]


def normal_stress(body: ElasticBody, u: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """n . F S N for the normal N = n at points in all cells."""
    d, domain, material = body.dimension, body.space.mesh, body.material
    body.u.x.array[:] = u
    deformation = ufl.Identity(d) + ufl.grad(body.u)
    strain = green_strain(ufl.grad(body.u))
    stress = material.lame * ufl.tr(strain) * ufl.Identity(d) + 2 * material.shear * strain
    points = basix.make_quadrature(domain.basix_cell(), 2)[0]
    count = domain.topology.index_map(d).size_local
    values = fem.Expression(deformation * stress, points).eval(
        domain, np.arange(count, dtype=np.int32)
    )
    return normal @ values.reshape(-1, d, d) @ normal


@pytest.mark.parametrize(("cell", "degree"), [("quadrilateral", 1), ("triangle", 2)])
@pytest.mark.parametrize(
    "case",
    [
        pytest.param({}, id="level"),
        pytest.param({"young": (1.0, 7.0), "poisson": 0.0}, id="two-moduli"),
        pytest.param({"friction": 5.0}, id="level-friction"),
        pytest.param({"slope": SLOPE, "poisson": 0.0}, id="sloped"),
        pytest.param(
            {"slope": SLOPE, "poisson": 0.0, "young": (1.0, 7.0), "friction": 5.0},
            id="sloped-two-moduli-friction",
        ),
        pytest.param({"width": 0.6, "friction": 5.0}, id="narrow"),
    ],
)
def test_uniform_pressure(cell, degree, case):
    nodal, single, stress = Patch(cell=cell, degree=degree, **case).errors()
    assert nodal < UNIFORM
    assert stress < UNIFORM
    assert single < 1e-6  # round-off of gaps times gamma_h


@pytest.mark.parametrize(
    ("cell", "degree"), [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1)]
)
@pytest.mark.parametrize(
    "case",
    [
        pytest.param({}, id="level"),
        pytest.param(
            {"slope": SLOPE, "poisson": 0.0, "young": (1.0, 7.0), "friction": 5.0}, id="sloped"
        ),
    ],
)
def test_uniform_pressure_in_space(cell, degree, case):
    """On the polygons that facets of both sides have in common."""
    nodal, single, stress = Patch(dimension=3, cell=cell, degree=degree, **case).errors()
    assert nodal < UNIFORM
    assert stress < UNIFORM
    assert single < 1e-5


@pytest.mark.parametrize(
    ("points", "degree", "least", "most"),
    [
        ("gauss", 1, 1e-3, 5e-2),
        ("gauss", 2, 5e-3, 5e-2),
        ("nodes", 1, 5e-2, 0.3),
        ("nodes", 2, 0.1, 0.5),
    ],
)
def test_without_common_refinement_it_is_not_uniform(points, degree, least, most):
    """Rules on the facets of one side leave an error in the nodal pressure."""
    patch = Patch(degree=degree, points=points, cuts=False, friction=5.0)
    assert least < patch.errors()[0] < most


@pytest.mark.parametrize(
    ("points", "below", "above", "error"),
    [("nodes", 6, 6, 1e-3), ("nodes", 6, 7, 0.035), ("gauss", 6, 7, 6e-3), ("nodes", 24, 28, 0.03)],
)
def test_a_block_at_rest_on_another_as_scenes_have_it(
    points: str, below: int, above: int, error: float
) -> None:
    """Without common refinement: stresses of cells beside weight over area, over the pressure.

    After steps from the equilibrium, which stay there.
    """
    stone = {"model": "elastic", "young": 1e9, "poisson": 0.0, "density": 2000.0, "width": 1.0}
    low = stone | {"name": "low", "height": 0.5, "cells": [below, below]}
    top = stone | {"name": "top", "on": "low", "height": 1.0, "cells": [above, above]}
    contact = {"friction": 0.0, "points": points}
    case = parse_scene({"block": [low, top], "contact": contact, "time": {"end": 0.01}})
    assembly = build(case)
    state, remark = initial_state(case, assembly)
    assert not remark
    for _ in range(5):
        state, _ = assembly.stepper.advance(state, 1e-3)
    pressure, largest = 2000.0 * 9.81 * 1.0, 0.0
    for member, own in zip(assembly.members, assembly.stepper.system.slices, strict=False):
        body = member.body
        body.u.x.array[:] = state.u[own]
        strain = green_strain(ufl.grad(body.u))
        cells = fem.functionspace(body.space.mesh, ("DG", 0))
        places = cells.element.interpolation_points
        stress = fem.Function(cells)
        stress.interpolate(
            fem.Expression(
                body.material.lame * ufl.tr(strain) + 2 * body.material.shear * strain[1, 1],
                places() if callable(places) else places,
            )
        )
        count = cells.dofmap.index_map.size_local
        middle = compute_midpoints(body.space.mesh, 2, np.arange(count, dtype=np.int32))[:, 1]
        off = stress.x.array[:count] / body.thickness + 2000.0 * 9.81 * (1.5 - middle)
        largest = max(largest, float(np.abs(off).max()) / pressure)
    assert largest < error
