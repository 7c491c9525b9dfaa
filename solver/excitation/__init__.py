"""Motions of the ground; no dolfinx here."""
