"""The engine of rigid blocks in space, compiled."""
