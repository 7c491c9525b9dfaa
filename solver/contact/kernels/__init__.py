"""Passes over the points of a surface as compiled loops: arrays in, arrays out."""
