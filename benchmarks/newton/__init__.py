"""A step solved by a textbook semi-smooth Newton method, to compare with."""
