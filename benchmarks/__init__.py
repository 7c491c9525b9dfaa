"""Measurements that are too long for the tests: each script writes the table beside it."""
