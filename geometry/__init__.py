"""Shapes and meshes of blocks and of what carries them, without time or force.

Nothing is imported here: `geometry.block` and `geometry.tags` need the standard library only, and
`geometry.density` too, but for its values at points and over cells; `geometry.arrangement`,
`geometry.foundation`, `geometry.grading` numpy. So do `geometry.shapes` and what it is built on
(`solid`, `convex`, `overlap`, `moments`, `polygon`, `surface`, `surface_file`, `ply_file`), until a
hull, an overlap or a file asks for scipy, VTK or Gmsh. `geometry.gmsh_model` and what is built on
it (`mesh`, `frame_mesh`, `body_mesh`) need dolfinx and Gmsh.
"""
