"""A small library of contact problems with known answers, for tests, benchmarks and demos.

- `hertz`: closed forms of the contact of two cylinders under normal load (Hertz), and under an
  additional tangential load (Cattaneo, Mindlin); numbers in, numbers out, no mesh.
- `disc_mesh`: a graded quadrilateral mesh of half a disc.
- `pressed_disc`: that half disc as an elastic body on rigid ground, pressed to given loads.
- `fixed_pair`: a pair of bodies with one interface that is given.
- `load_steps`: a sequence of equilibria under loads or moved supports; contact forces as tractions.

`demos/hertz/hertz.py` uses all that Hertz's line contact needs. Runs of scenes import nothing from
here.
"""
