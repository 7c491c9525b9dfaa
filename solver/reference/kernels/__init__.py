"""Compiled loops of closed forms."""
