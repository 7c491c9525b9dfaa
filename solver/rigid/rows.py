"""The energies in the rows of rigid blocks, in the plane and in space alike. Compiled."""

from __future__ import annotations

from solver.history.columns import positions
from solver.law.compiled import compiled
from solver.types import Array

ENERGY = positions("energy", 3)
"""Places of the energies within their part of a row: the same in the plane."""


@compiled
def write_energies(stored: tuple[float, float, float], exchanged: Array, row: Array) -> None:
    """The columns of the energies; the total at the start is still in the error of the ledger.

    Of kinetic, gravity and spring energy, and what was taken in, lost in friction, damping, contact
    and time stepping, J, (5,).
    """
    total = stored[0] + stored[1] + stored[2]
    row[ENERGY.kinetic_J], row[ENERGY.strain_J], row[ENERGY.gravity_J] = stored[0], 0.0, stored[1]
    row[ENERGY.spring_J], row[ENERGY.interface_J] = stored[2], 0.0
    row[ENERGY.input_J], row[ENERGY.friction_J] = exchanged[0], exchanged[1]
    row[ENERGY.damping_J], row[ENERGY.contact_J] = exchanged[2], exchanged[3]
    row[ENERGY.contact_damping_J] = 0.0
    row[ENERGY.numerical_J], row[ENERGY.total_J] = exchanged[4], total
    row[ENERGY.ledger_error_J] = total - exchanged[0] + exchanged[1:].sum()
