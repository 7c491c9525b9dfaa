"""Generalized-alpha and the control of its steps: pure numbers."""
