"""A small library of contact problems with known answers, for tests, benchmarks and demos.

Closed forms (numbers in, numbers out, no mesh):

- `hertz`: contact of two cylinders or spheres under normal load (Hertz), and under an additional
  tangential load (Cattaneo, Mindlin).
- `newmark`: a rigid block that slides on rigid ground (Newmark).
- `bar_impact`: an elastic bar that hits a wall again and again (Dabaghi and others).

Posing such problems to the finite elements, from Python rather than from a scene:

- `disc_mesh`: a graded quadrilateral mesh of half a disc.
- `pressed_disc`: that half disc as an elastic body on rigid ground, pressed to given loads.
- `load_steps`: a sequence of equilibria under loads or moved supports; contact forces as tractions.

`demos/hertz/hertz.py` uses all that Hertz's line contact needs. Runs of scenes import nothing from
here.
"""
