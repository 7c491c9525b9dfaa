"""Signorini and Coulomb: friction, the local contact problem and the velocity solve."""
