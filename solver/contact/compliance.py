"""Contact compliance (Delassus operator) of an elastic body.

It is computed column by column, as points come near contact.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from solver.contact.points import ContactPoints
from solver.mechanics.elastic_body import ElasticBody
from solver.mechanics.factorization import Factorization

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Compliance:
    """What unit forces at contact points move: K^-1 (force rows)^T, read through other rows.

    In the frame that rotates with the body all of it is constant. A column is computed when its
    point first comes near contact, so that a standing block never pays for its sides and top.
    """

    def __init__(
        self,
        body: ElasticBody,
        points: ContactPoints,
        factor: Factorization,
        force_rows: Array | sp.csr_matrix,
        read_rows: Array | sp.csr_matrix,
    ):
        """Start without any column.

        Args:
            body: The body that the factorization belongs to.
            points: Its contact points.
            factor: Factorized tangent or mass.
            force_rows: Rows (points d, layer unknowns) whose transpose turns point forces into
                nodal ones.
            read_rows: Rows of the same shape that read the response.
        """
        self.body, self.points, self.factor = body, points, factor
        self.force_rows, self.read_rows = force_rows, read_rows
        self._place = np.full(points.count, -1)
        self._response = np.empty((body.size, 0))
        self._matrix = np.empty((points.count * body.dimension, 0))
        self._last: Indices = np.empty(0, dtype=np.int64)
        self._gathered: tuple[Array, Array] = np.empty((0, 0)), np.empty((body.size, 0))

    def of(self, chosen: Indices) -> tuple[Array, Array]:
        """Compliance (m d, m d) among the points `chosen`, responses to them (owned, m d)."""
        if len(chosen) == len(self._last) and np.array_equal(chosen, self._last):
            return self._gathered
        missing = chosen[self._place[chosen] < 0]
        if len(missing):
            self._compute(missing)
        rows, columns = self._expand(chosen), self._expand(self._place[chosen])
        self._gathered = self._matrix[np.ix_(rows, columns)], self._response[:, columns]
        self._last = chosen
        return self._gathered

    def in_frame(self, chosen: Indices, frame: Array) -> Array:
        """Compliance among the points `chosen` in another frame, (m, d, m, d).

        Args:
            chosen: Numbers of the points.
            frame: Its rows are unit vectors.
        """
        m, d = len(chosen), self.body.dimension
        blocks = self.of(chosen)[0].reshape(m, d, m, d).transpose(0, 2, 1, 3)
        return np.ascontiguousarray((frame @ blocks @ frame.T).transpose(0, 2, 1, 3))

    def _expand(self, points: Indices) -> Indices:
        """Row numbers of the d directions of points."""
        d = self.body.dimension
        return (points[:, None] * d + np.arange(d)).ravel()

    def _compute(self, missing: Indices) -> None:
        """Solve for the columns of further points."""
        d, layer = self.body.dimension, self.points.layer
        rows = self.force_rows[self._expand(missing)]
        unit = (rows if isinstance(rows, np.ndarray) else rows.toarray()).T
        right = np.zeros((self.body.owned, d, unit.shape[1]))
        layer.add(right, unit.reshape(layer.size, d, -1))
        right = right.reshape(self.body.size, -1)
        right[self.body.fixed] = 0.0
        response = self.factor.solve_many(right)
        near = layer.gather(response.reshape(self.body.owned, -1)).reshape(layer.size * d, -1)
        self._place[missing] = self._matrix.shape[1] // d + np.arange(len(missing))
        self._matrix = np.hstack([self._matrix, self.read_rows @ near])
        self._response = np.hstack([self._response, response])
