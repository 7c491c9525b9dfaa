"""Scenes that tests of several files start from."""

#: The paper's block of granite, upright; further keys of the block may follow.
BLOCK = """[[block]]
width = 0.25
height = 1.0
thickness = 0.75
mass = 503.0
young = 5.0e10
poisson = 0.2"""

#: A rigid block on it, half as high; further keys of it may follow.
UPPER = """
[[block]]
name = "upper"
on = "block"
width = 0.25
height = 0.5
thickness = 0.75
mass = 250.0
model = "rigid"
"""

#: What both may stand on.
OSCILLATOR = '[foundation]\nkind = "oscillator"\nmass_ratio = 0.5\nperiod = 0.4\n'

#: The paper's block released at three degrees; without a [time].
GRANITE = f"""
title = "A block of granite"
{BLOCK}
tilt_deg = 3.0
[contact]
friction = 0.7
"""

#: The same for a moment, in a few hundred steps.
SHORT_GRANITE = GRANITE + "[time]\nend = 0.3\nstep = 0.001\n"
