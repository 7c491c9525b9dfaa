"""Shapes and meshes of blocks and of what carries them, without time or force.

Nothing is imported here: `geometry.block` and `geometry.tags` need the standard library only, and
`geometry.density` too, but for its values at points and over cells;
`geometry.arrangement`, `geometry.foundation` and `geometry.grading` numpy; `geometry.gmsh_model`
and what is built on it (`mesh`, `frame_mesh`, `disc_mesh`) dolfinx and Gmsh.
"""
