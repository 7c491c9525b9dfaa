"""Rigid bodies that meet each other: scenes, times and accuracy beside MuJoCo, the trilith."""
