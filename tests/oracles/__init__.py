"""Scenes of seconds with the numbers that physics says they have: the contract of all changes."""
