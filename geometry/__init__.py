"""Shapes and meshes of blocks and of what carries them; knows nothing of time or force.

Nothing is imported here: `geometry.block` and `geometry.tags` need the standard library only,
`geometry.arrangement` and `geometry.foundation` numpy, `geometry.mesh` dolfinx and Gmsh.
"""
