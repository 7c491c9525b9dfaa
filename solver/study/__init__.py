"""Studies: many runs of scenes, and their common results."""
