"""The portion of the live load that counts as inertia."""
