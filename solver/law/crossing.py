"""Limits for edges of two faces that cross, in scenes with a mesh."""

from __future__ import annotations

PARALLEL_ANGLE = 1e-2
"""Edges that enclose less than this angle (rad) are parallel and do not cross. The polygon in which
two faces touch has hardly a corner there, and a crossing would run along both edges when they turn
or bend a little. Where such an edge enters the other face, it touches along that face's normal."""

STEEPEST_COSINE = 0.5
"""Least cosine between the normal of two edges and that of the lower face: 60 degrees, as for the
faces themselves. Where it is steeper, a corner is nearer than the crossing."""

TURNED_AWAY_COSINE = 0.5
"""Least cosine between the normal of the lower face and the opposite one of the upper face."""
