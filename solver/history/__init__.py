"""The table that a run leaves: its columns and its rows."""
