"""Synthetic ground motions: Boore's stochastic method with a point source."""
