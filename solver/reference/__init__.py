"""Closed forms and rigid-body answers to compare the finite elements with; no dolfinx here."""
