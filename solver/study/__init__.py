"""Studies: many runs of scenes, and what they say together."""
