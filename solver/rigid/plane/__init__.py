"""The engine of rigid blocks in the plane, compiled."""
