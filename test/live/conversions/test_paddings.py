"""The parameter ``paddings``: patterns and metres."""

import pytest

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.paddings import paddings_of


def test_each_pattern_has_its_padding_in_the_order_given():
    given = ['*=0.01', 'a=b=0', 'hand/finger_?=2e-2']
    assert paddings_of(given) == (('*', 0.01), ('a=b', 0.0), ('hand/finger_?', 0.02))
    assert paddings_of([]) == ()


@pytest.mark.parametrize(
    'text', ['', 'hand', '=0.1', 'hand=', 'hand=-0.1', 'hand=nan', 'hand=inf']
)
def test_what_is_no_padding_is_refused_with_what_is(text):
    with pytest.raises(ArgumentError, match='must be PATTERN=METRES') as error:
        paddings_of(['*=0.01', text])
    assert repr(text) in str(error.value)
