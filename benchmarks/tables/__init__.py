"""Tables and pictures of `benchmarks/`, `docs/` and README: what made each of them, and when.

`make tables` makes those that are older than the code that they speak of.
"""
