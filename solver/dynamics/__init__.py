"""Time stepping: scheme, steps, their nonlinear solve and their sizes."""
