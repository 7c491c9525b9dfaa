"""Extreme scenes: a check of the program itself."""
