"""Compiled functions of meshed bodies: what each does, with shapes and units.

Arrays are of float64 (`Array`), int64 (`Indices`) or bool (`Mask`), in one piece (C order). Those that
a function fills in are named so; it keeps none of them.
"""

from solver.types import Array, Indices, Mask
