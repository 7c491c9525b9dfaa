"""Losses of impacts over physical and numerical parameters, and the calibration of one of them."""
