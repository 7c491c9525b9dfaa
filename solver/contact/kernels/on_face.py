"""Points with tractions over facets: where they are, and their forces, one pass each; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.contact.kernels.facets import Chain, Facets, stand_on_face
from solver.contact.kernels.nitsche import add_forces, augment, evaluate
from solver.contact.kernels.way import StandArrays, add_spread, forces_in_space
from solver.law.compiled import compiled
from solver.types import Array, Indices

Bodies = tuple[Indices, Array, Array, Array, Indices, Array, Array]
"""What `evaluate_both` takes of both bodies, before what it fills in."""


@compiled
def evaluate_both(
    index: Indices,
    table: Array,
    reference: Array,
    displacement: Array,
    numbers: Indices,
    at_rest: Array,
    carrier_moved: Array,
    state: Array,
    carrier: Array,
) -> None:
    """Fill in positions and tractions of points as `evaluate`, and positions of nodes of a face.

    Args:
        index: Of the `SurfaceRows`, like all up to `reference`.
        table: Of the rows.
        reference: Of the rows.
        displacement: Of the nodes of the body of the points, (n, d), m.
        numbers: Where the nodes of the face are among those of `carrier_moved`.
        at_rest: Their undeformed positions, (n, d), m.
        carrier_moved: Displacements of nodes of the body that carries, (n, d), m.
        state: The values of a `NitscheState`.
        carrier: Positions of the nodes of the face, (n, d), m.
    """
    evaluate(index, table, reference, displacement, state)
    for n in range(len(numbers)):
        carrier[n] = at_rest[n] + carrier_moved[numbers[n]]


@compiled
def observe_over_face(
    chain: Chain | None,
    facets: Facets | None,
    bodies: Bodies,
    inverse_gamma: Array,
    frame: Array,
    state: Array,
    carrier: Array,
    place: Array,
    stand: tuple[Any, ...],
    y: Array,
) -> None:
    """Evaluate both bodies, and fill in where points are over a face.

    Args:
        chain: As `stand_on_face` takes it.
        facets: Likewise.
        bodies: As `evaluate_both` takes them, up to `carrier_moved`.
        inverse_gamma: 1/gamma_h, (p,), m/Pa.
        frame: Rows normal and tangents of the step, (d, d).
        state: The values of a `NitscheState`, filled in like all that follows.
        carrier: Positions of the nodes of the face, (n, d), m.
        place: (g, s), (p, d), m.
        stand: The fields of the `Feet` of the points.
        y: (p, d), m.
    """
    evaluate_both(*bodies, state, carrier)
    points = len(place)
    stand_on_face(chain, facets, state[:points], carrier, frame, place, stand)
    augment(place, state[points : 2 * points], inverse_gamma, frame, y)


@compiled
def add_forces_on_face(
    index: Indices,
    table: Array,
    old: Array,
    new: Array,
    force: Array,
    weight: float,
    old_weight: float,
    new_weight: float,
    pulls: bool,
    scale: Array,
    before: StandArrays,
    after: StandArrays,
    frame: Array,
    facet: float,
    nodal: Array,
    numbers: Indices,
    on_face: Array,
) -> None:
    """Add point forces, and what they pull on tractions, to forces on nodes of both bodies.

    Args:
        index: As in `add_forces_on_plane`, like all up to `scale`.
        table: Of the rows.
        old: The values of the `NitscheState` at t_n.
        new: Those at t_{n+1}.
        force: f, (p, d), N.
        weight: By which forces count.
        old_weight: By which the traction at t_n does.
        new_weight: By which that at t_{n+1} does.
        pulls: Whether there is a theta term.
        scale: Of the `TractionPull`.
        before: Where points stand at t_n.
        after: Where they stand at t_{n+1}.
        frame: Rows normal and tangents of the step, (d, d).
        facet: Length of the smallest facet, m.
        nodal: Forces on nodes of the body of the points, (n, d), N.
        numbers: Where the nodes of the face are among those of `on_face`.
        on_face: Forces on nodes of the body that carries, (n, d), N.
    """
    weighted, vectors = weight * force, np.empty(force.shape)
    forces_in_space(before, after, frame, facet, weighted, vectors)
    pull = scale, weighted, frame, old_weight, new_weight
    add_forces(index, table, old, new, vectors, pulls, *pull, nodal)
    if not vectors.any():
        return
    reaction = np.zeros((len(numbers), len(frame)))
    add_spread(before[0], before[1], 0.5, -vectors, reaction)
    add_spread(after[0], after[1], 0.5, -vectors, reaction)
    for n in range(len(numbers)):
        on_face[numbers[n]] += reaction[n]
