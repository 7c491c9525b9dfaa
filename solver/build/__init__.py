"""From a scene to its bodies, its contacts and a stepper."""
