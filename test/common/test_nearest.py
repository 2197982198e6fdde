"""Names that somebody may have meant."""

import pytest

from drake_geom_ros.common.nearest import nearest

NAMES = ['Ball', 'right', 'wrist_1_link', 'wrist_2_link', 'elbow']


@pytest.mark.parametrize(
    ('name', 'like'),
    [
        ('ball', {'Ball'}),
        ('rigth', {'right'}),
        ('wrist_4_link', {'wrist_1_link', 'wrist_2_link'}),
    ],
)
def test_the_names_that_are_most_like_it(name, like):
    found = nearest(name, NAMES)
    assert found.startswith('; nearest: ')
    assert {each.strip("'") for each in found.partition(': ')[2].split(', ')} == like


@pytest.mark.parametrize('name', ['', 'q' * 100_000])
def test_what_is_like_none_says_nothing(name):
    assert nearest(name, NAMES) == ''
