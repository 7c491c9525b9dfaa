"""The compiled world of rigid bodies (solver/kernels) over its C interface, for tests."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solver.kernels.library import library

Array = NDArray[np.float64]


def kernels() -> ctypes.CDLL:
    """The library of the kernels."""
    loaded = library()
    loaded.world_new.restype = ctypes.c_void_p
    return loaded


def pointer(values: Sequence[float] | Array, kind: type = np.float64) -> ctypes.c_void_p:
    """A pointer to an array, which the caller keeps."""
    return np.ascontiguousarray(values, dtype=kind).ctypes.data_as(ctypes.c_void_p)


class PlaneWorld:
    """Boxes in the plane over level ground, with one law for all pairs."""

    def __init__(self, kernels: ctypes.CDLL, friction: float, restitution: float = 0.0):
        """Begin with the ground alone."""
        self._kernels, self.count = kernels, 0
        gravity, scheme = np.array([0.0, -9.81]), np.array([0.0, 0.5, 0.5])
        self._world = ctypes.c_void_p(kernels.world_new(2, pointer(gravity), pointer(scheme), 1))
        law = np.array([friction, friction, 0.0, 0.0, 0.0, restitution])
        kernels.world_law(self._world, pointer(law))
        self._body(kernels.world_half_space(self._world), 1, 1.0, 1.0, (0.0, 0.0), 0.0, (0.0, 0.0))

    def box(
        self,
        size: tuple[float, float],
        place: Sequence[float] | Array,
        mass: float,
        *,
        turn: float = 0.0,
        velocity: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add a box by its size (m), centre (m), mass (kg), turn (rad, anticlockwise), velocity."""
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * size
        shape = self._kernels.world_polygon(self._world, pointer(corners), 4)
        inertia = mass * (size[0] ** 2 + size[1] ** 2) / 12
        self._body(shape, 0, mass, inertia, place, turn, velocity)

    def _body(
        self,
        shape: int,
        mobility: int,
        mass: float,
        inertia: float,
        place: Sequence[float] | Array,
        turn: float,
        velocity: tuple[float, float],
    ) -> None:
        """Add a body."""
        numbers = np.array(
            [mass, 1.0, 0.0, 0.0, inertia, 0.0, 0.0, *place, turn, *velocity, 0.0], float
        )
        self._kernels.world_body(self._world, shape, mobility, pointer(numbers))
        self.count += 1

    def begin(self) -> None:
        """Begin with the bodies that are there."""
        laws = np.zeros(self.count**2, dtype=np.int32)
        none = np.zeros(self.count, dtype=np.int32)
        self._kernels.world_begin(
            self._world, pointer(laws, np.int32), pointer(none, np.int32), pointer(none, np.int32)
        )

    def run(self, steps: int, dt: float) -> int:
        """Take steps; returns how many were solved."""
        arguments = steps, ctypes.c_double(dt), ctypes.c_double(dt / 4096)
        return int(self._kernels.world_run(self._world, *arguments, None, None, None, None))

    def state(self) -> tuple[Array, Array]:
        """Of each body x, y, turn, velocities, spin; energies, exchanges and counts of the step."""
        bodies, step = np.zeros((self.count, 11)), np.zeros(13)
        self._kernels.world_state(
            self._world,
            bodies.ctypes.data_as(ctypes.c_void_p),
            step.ctypes.data_as(ctypes.c_void_p),
        )
        return bodies[:, :6], step

    def ledger(self) -> float:
        """Stored energies less input plus losses, J."""
        step = self.state()[1]
        return float(step[:3].sum() - step[3] + step[4:8].sum())
