"""The thicknesses beside the legend of a wall."""

import numpy as np
import pytest

from glassworkbench.document.wall_legend import round_steps


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(3.03, 4.0, [3.03, 3.2, 3.4, 3.6, 3.8, 4.0]), (2.84, 3.15, [2.84, 2.9, 3.0, 3.1]), (2.0, 7.0, [2, 3, 4, 5, 6, 7])],
)
def test_a_legend_begins_at_the_smallest_wall_and_goes_on_in_round_steps(low, high, expected):
    steps = round_steps(low, high)
    np.testing.assert_allclose(steps, expected)
