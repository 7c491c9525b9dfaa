"""Energy balance of a run, from columns of its history."""

from __future__ import annotations

import math

import numpy as np

from solver.history.columns import DISSIPATED_ENERGIES
from solver.history.history import History
from solver.results.motion import centres
from solver.scene import BlockSpec, Scene
from solver.types import Array


def scale(work: Array, *, above_rest: float, weight_height: float) -> float:
    """The energy (J) that gains and errors are compared with.

    (Energy at the start above rest) + integral of |power of the ground| + 1e-3 sum of m g H. The
    integral is the total variation of the ground's work over the rows of the history. Above rest is
    the kinetic energy at the start and the gravity energy above that of standing upright at their
    places; less than nothing counts as nothing.
    """
    return max(0.0, above_rest) + float(np.sum(np.abs(np.diff(work)))) + 1e-3 * weight_height


def largest_gain_fraction(total: Array, work: Array, scale: float) -> float:
    """Largest of (total - total at start - work of the ground), over the scale."""
    return _over(float(np.max(total - total[0] - work)), scale)


def ledger_error_fraction(error: Array, scale: float) -> float:
    """Largest |ledger error|, over the scale."""
    return _over(float(np.max(np.abs(error))), scale)


def _over(energy: float, scale: float) -> float:
    """An energy over the scale; not known where nothing weighs and nothing moves."""
    return energy / scale if scale > 0 else math.nan


def losses(history: History) -> dict[str, float]:
    """Energy dissipated by the end, by cause, J."""
    return {f"{name}_J": float(history[f"energy.{name}_J"][-1]) for name in DISSIPATED_ENERGIES}


def upright_centre(scene: Scene, block: BlockSpec) -> Array:
    """Centre of mass of a block that stands upright at its place, on all that carries it, m, (d,).

    In the frame of the foundation: its surface is at level 0, its centre at x = 0.
    """
    own = np.array(block.shape.centre_of_mass(scene.dimension))
    return scene.poses(upright=True)[block.name](own[None])[0]


def gravity_above_upright(scene: Scene, history: History) -> Array:
    """Gravity energy of all blocks above that of their upright places, J, over the rows."""
    gravity = np.array(scene.gravity_vector)
    energy = np.zeros(len(history))
    for block in scene.blocks:
        raised = centres(history, block.name) - upright_centre(scene, block)
        energy -= block.shape.mass * (raised @ gravity)
    return energy
