"""Layouts of files with recorded motions: one file each, and `table`, where they stand."""
