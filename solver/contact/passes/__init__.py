"""Interfaces of meshed bodies whose passes over all points are one compiled call each."""
