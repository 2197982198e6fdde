"""Colours."""

import math

import pytest

from drake_geom_ros.geometry import Rgba


def test_channels():
    colour = Rgba(0.1, 0.2, 0.3)
    assert (colour.r(), colour.g(), colour.b(), colour.a()) == (0.1, 0.2, 0.3, 1.0)
    assert colour.rgba.tolist() == [0.1, 0.2, 0.3, 1.0]
    assert Rgba() == Rgba(1, 1, 1, 1)
    assert repr(Rgba(1, 0, 0)) == 'Rgba(r=1.0, g=0.0, b=0.0, a=1.0)'
    assert Rgba() != (1, 1, 1, 1)


def test_setting():
    colour = Rgba()
    colour.set(0, 0.5, 1)
    assert colour == Rgba(0, 0.5, 1, 1)
    colour.set([1, 0, 0, 0.5])
    assert colour == Rgba(1, 0, 0, 0.5)
    colour.set([0, 0, 1])
    assert colour == Rgba(0, 0, 1, 1)
    colour.update(g=0.25, a=0)
    assert colour == Rgba(0, 0.25, 1, 0)


@pytest.mark.parametrize(
    'bad', [(1.1, 0, 0), (0, -0.1, 0), (0, 0, math.nan), (0, 0, 0, 2), ('red', 0, 0)]
)
def test_a_refused_value_changes_nothing(bad):
    with pytest.raises(RuntimeError, match=r'\[0, 1\]|must be numbers'):
        Rgba(*bad)
    colour = Rgba(0.1, 0.2, 0.3)
    with pytest.raises(RuntimeError, match=r'\[0, 1\]|must be numbers'):
        colour.set(*bad)
    with pytest.raises(RuntimeError, match='in'):
        colour.update(a=2)
    with pytest.raises(RuntimeError, match='3 or 4'):
        colour.set([0.1, 0.2])
    assert colour == Rgba(0.1, 0.2, 0.3)
