"""Measurements that are too long for the tests: each script writes the table beside it.

The folders hold the studies of the program itself, which `rockslip study` runs from here, and a
small library of problems with known answers.
"""
