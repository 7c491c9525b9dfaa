"""Meshed foundations reduced to the nodes that are touched or supported, and some modes."""
