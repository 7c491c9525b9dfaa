"""Shapes and meshes of blocks and of what carries them, without time or force.

Nothing is imported here: `geometry.block` and `geometry.tags` need the standard library only,
`geometry.arrangement`, `geometry.foundation`, `geometry.grading` and `geometry.solid` with what it is
built on (`convex`, `moments`, `polygon`, `surface`, `surface_file`) numpy, and scipy, VTK and Gmsh
where a hull, an overlap or a file asks for them; `geometry.gmsh_model` and what is built on it (`mesh`, `frame_mesh`, `disc_mesh`) dolfinx and Gmsh.
"""
