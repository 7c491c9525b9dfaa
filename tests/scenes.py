"""Scenes that tests of several files start from."""

#: The paper's block of granite, upright; further keys of the block may follow.
BLOCK = """[[block]]
width = 0.25
height = 1.0
thickness = 0.75
mass = 503.0
young = 5.0e10
poisson = 0.2"""

#: The same released at three degrees; without a [time].
GRANITE = f"""
title = "A block of granite"
{BLOCK}
tilt_deg = 3.0
[contact]
friction = 0.7
"""

#: The same for a moment, in a few hundred steps.
SHORT_GRANITE = GRANITE + "[time]\nend = 0.3\nstep = 0.001\n"
