"""Points with tractions over a plane: where they are, and their forces, one pass each; compiled."""

from __future__ import annotations

import numpy as np

from solver.contact.kernels.nitsche import add_forces, augment, evaluate
from solver.contact.kernels.plane import places, vectors_of
from solver.law.compiled import compiled
from solver.types import Array, Indices, Mask


@compiled
def observe_over_plane(
    index: Indices,
    table: Array,
    reference: Array,
    displacement: Array,
    plane: Array,
    inverse_gamma: Array,
    state: Array,
    place: Array,
    beyond: Mask,
    y: Array,
) -> None:
    """Fill in positions and tractions as `evaluate`, gaps and slips, and augmented positions.

    Args:
        index: Of the `SurfaceRows`, like all up to `reference`.
        table: Of the rows.
        reference: Of the rows.
        displacement: Of the nodes, (n, d), m.
        plane: Where it lies, as in `places`.
        inverse_gamma: 1/gamma_h, (p,), m/Pa.
        state: The values of a `NitscheState`.
        place: As in `places`.
        beyond: As in `places`.
        y: (p, d), m.
    """
    evaluate(index, table, reference, displacement, state)
    points = len(reference)
    places(state[:points], plane, place, beyond)
    augment(place, state[points : 2 * points], inverse_gamma, plane[4:], y)


@compiled
def add_forces_on_plane(
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
    frame: Array,
    nodal: Array,
    total: Array,
) -> None:
    """Add point forces, and what they pull on tractions, to forces on nodes; fill in their sum.

    Args:
        index: As in `observe_over_plane`.
        table: Likewise.
        old: The values of the `NitscheState` at t_n.
        new: Those at t_{n+1}.
        force: f, (p, d), N: normal, tangential.
        weight: By which forces count, as in `ForceWeights`.
        old_weight: By which the traction at t_n does.
        new_weight: By which that at t_{n+1} does.
        pulls: Whether there is a theta term.
        scale: Of the `TractionPull`.
        frame: Rows normal and tangents, (d, d).
        nodal: Forces on nodes, (n, d), N.
        total: Sum of the forces in space, (d,), N; (0,) where nobody asks.
    """
    weighted, vectors = weight * force, np.empty(force.shape)
    vectors_of(weighted, frame, vectors)
    if len(total) > 0:
        total[:] = 0.0
        for p in range(len(vectors)):
            total += vectors[p]
    pull = scale, weighted, frame, old_weight, new_weight
    add_forces(index, table, old, new, vectors, pulls, *pull, nodal)


@compiled
def press_on_plane(
    index: Indices,
    table: Array,
    reference: Array,
    displacement: Array,
    plane: Array,
    inverse_gamma: Array,
    old: Array,
    force: Array,
    weight: float,
    old_weight: float,
    new_weight: float,
    pulls: bool,
    scale: Array,
    state: Array,
    place: Array,
    beyond: Mask,
    y: Array,
    nodal: Array,
    total: Array,
) -> None:
    """Fill in where points are over a plane, and add their forces there to those on nodes.

    Arguments are those of `observe_over_plane` and of `add_forces_on_plane`. The values `old` may
    be those that are filled in: then the points are there at both ends of the step.
    """
    where = displacement, plane, inverse_gamma
    observe_over_plane(index, table, reference, *where, state, place, beyond, y)
    how = weight, old_weight, new_weight, pulls, scale, plane[4:]
    add_forces_on_plane(index, table, old, state, force, *how, nodal, total)
