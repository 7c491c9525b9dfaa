"""Modes in which a block at rest begins to move under a sudden acceleration: Shenton's map."""
