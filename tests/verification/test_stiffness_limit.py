"""The elastic block as it grows stiffer: the rigid one in the same steps."""

import pytest

from benchmarks.stiffness_limit import distance, elastic, in_whole_steps, rigid


@pytest.mark.slow
@pytest.mark.serial
def test_elastic_blocks_tend_to_the_rigid_one() -> None:
    """Within 1 % at 1e13 Pa and 6 % at 1e11 Pa; a fifth off at 1e9 Pa."""
    stiff = in_whole_steps(rigid(1e-3))
    for young, least, most in ((1e9, 0.1, 0.5), (1e11, 0.0, 0.06), (1e13, 0.0, 0.01)):
        apart = distance(in_whole_steps(elastic(young, 1e-3)), stiff)
        assert least <= apart < most
