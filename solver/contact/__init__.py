"""Contact of a meshed body with a plane: its points, its laws, the small problem that they make."""
