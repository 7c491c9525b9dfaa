"""Sums over the nodes of a meshed body as compiled loops: arrays in, arrays out."""
