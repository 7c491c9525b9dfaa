"""Elastic bodies: material, kinematics, forces, factorized tangents."""
