"""Compiled kernels: a world of rigid bodies in C++, and the library that is made of it."""
