"""Joint values behind one option, and a scene that is not taken for one."""

import pytest

from drake_geom_ros.command_line.spread_options import spread


@pytest.mark.parametrize(
    ('words', 'expected'),
    [
        ('--joints a=1 b=-2 scene.yaml', '--joints a=1 --joints b=-2 scene.yaml'),
        ('scene.yaml --joints a=1', 'scene.yaml --joints a=1'),
        ('--joints a=1 --joints b=2 s', '--joints a=1 --joints b=2 s'),
        ('--joints s a=1', '--joints s a=1'),
        ('--joints a=1 --out x=1.csv', '--joints a=1 --out x=1.csv'),
    ],
)
def test_each_value_gets_an_option(words, expected):
    assert spread(words.split()) == expected.split()
