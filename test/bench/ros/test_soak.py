"""How the soak measures that memory grows."""

import pytest

from bench.ros.soak import medians_by_minute, slope


def test_memory_is_told_for_each_minute_and_its_growth():
    flat = [(second, 100.0) for second in range(120)]
    assert medians_by_minute(flat) == [100.0, 100.0]
    assert slope(flat) == 0.0
    leak = [(second, 100.0 + second / 60.0) for second in range(150)]
    assert medians_by_minute(leak) == pytest.approx([100.5, 101.5, 102.25], abs=0.02)
    assert slope(leak) == pytest.approx(1.0)
    assert slope([(1.0, 5.0)]) == 0.0
