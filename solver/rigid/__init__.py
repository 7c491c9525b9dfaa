"""Scenes of rigid blocks alone: bodies of the compiled world, and rows of the history."""
