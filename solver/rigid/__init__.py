"""Rigid blocks: no mesh, three unknowns each in the plane, six in space, compiled by numba."""
