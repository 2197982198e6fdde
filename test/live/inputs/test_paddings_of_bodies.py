"""The padding of single bodies, against the distance of each point from each body."""

import numpy as np
import pytest
from live.inputs.sensing_node import Node, cloud

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.paddings import paddings_of
from drake_geom_ros.live.inputs.obstacle_sources import settings_of
from drake_geom_ros.scene_files import ObstacleSource

# Two balls of radius 0.1 m, far apart, and a sensor above.
SCENE = """
sources: [s]
frames:
- {name: arm, source: s}
- {name: wrist, source: s, parent: arm, static: true, pose: {position: [2, 0, 0]}}
- {name: eye, source: s, static: true, pose: {position: [1, 0, 3]}}
geometries:
- {name: ball, source: s, frame: arm, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: s, frame: wrist, shape: {type: sphere, radius: 0.1}}
"""
CENTRES = {'arm': [0.0, 0.0, 0.0], 'wrist': [2.0, 0.0, 0.0]}
NOISE = 0.01


def zones(gap, **changes):
    """Return the zone of a point at a gap [m] beside each ball: on, shell or map."""
    told = {}
    for name, centre in CENTRES.items():
        node = Node(scene=SCENE, self_filter='scene', noise=NOISE, resolution=0.01, **changes)
        node.move(100.0, [0.0, 0.0, 0.0])
        beside = np.add(centre, [0.0, 0.1 + gap, 0.0])
        points = np.array([beside, [1.0, 1.0, 0.0]])
        node.taker.take_cloud(cloud(points - [1.0, 0.0, 3.0], 'eye'))
        counts = node.input.counts
        told[name] = 'on' if counts.on_bodies else 'shell' if counts.in_shell else 'map'
        told['troubles'] = node.input.troubles()
    return told


@pytest.mark.parametrize('gap', [0.005, 0.015, 0.03, 0.045, 0.06, 0.09, 0.12])
@pytest.mark.parametrize('of_wrist', [0.0, 0.02, 0.1])
def test_each_body_has_its_own_padding(gap, of_wrist):
    told = zones(gap, padding=0.05, paddings=(('s::wrist', of_wrist),))
    for name, padding in (('arm', 0.05), ('wrist', of_wrist)):
        noise = min(NOISE, padding)
        expected = 'on' if gap <= noise else 'shell' if gap <= padding else 'map'
        assert told[name] == expected
    assert told['troubles'] == []


def test_of_patterns_that_fit_the_last_one_counts():
    both = (('*', 0.1), ('wrist', 0.02))
    assert zones(0.06, paddings=both)['wrist'] == 'map'
    assert zones(0.06, paddings=both[::-1])['wrist'] == 'shell'


def test_a_pattern_that_fits_no_body_is_a_trouble():
    (told,) = zones(0.06, paddings=(('wirst', 0.1),))['troubles']
    assert "'wirst'" in told


def test_a_source_with_a_padding_has_no_other():
    usual = Node().settings._replace(padding=0.05, paddings=(('wrist', 0.1),))
    plain = ObstacleSource('a', 'point_cloud', '/a')
    assert settings_of(plain, usual) == usual
    one = settings_of(ObstacleSource('a', 'point_cloud', '/a', padding=0.03), usual)
    assert (one.padding, one.paddings) == (0.03, ())
    own = (('arm', 0.2),)
    some = settings_of(ObstacleSource('a', 'point_cloud', '/a', paddings=own), usual)
    assert (some.padding, some.paddings, some.told_apart) == (0.05, own, 0.2)


def test_the_parameter_is_refused_by_its_name():
    with pytest.raises(ArgumentError, match="obstacle_paddings holds 'wrist'"):
        paddings_of(['wrist'], 'obstacle_paddings')
