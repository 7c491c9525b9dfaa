"""A scene from beginning to end."""
