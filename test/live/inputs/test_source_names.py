"""The sources of a node by parameters, scene files and services, and pairs that disagree."""

import pytest

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.inputs.obstacle_sources import (
    all_sources,
    obstacle_sources_of,
    refuse_taken_name,
    removable,
    saved_sources,
)
from drake_geom_ros.live.scene.map_sources import NamedSource, SourceOrigin
from drake_geom_ros.scene_files import ObstacleSource

FRONT = ObstacleSource('front', 'laser_scan', '/scan')
OTHER = ObstacleSource('front', 'laser_scan', '/other')
POINTS = ObstacleSource('points', 'point_cloud', '~/obstacles/points')


def test_each_source_is_named_where_it_comes_from_first():
    sources = all_sources(['points'], [FRONT], [ObstacleSource('rear', 'laser_scan', '/rear')])
    assert {name: each.origin for name, each in sources.items()} == {
        'points': SourceOrigin.PARAMETER,
        'front': SourceOrigin.PARAMETER,
        'rear': SourceOrigin.SCENE_FILE,
    }
    assert sources['points'].source == POINTS


def test_a_source_that_two_name_alike_is_one():
    assert all_sources([], [FRONT], [FRONT]) == {
        'front': NamedSource(FRONT, SourceOrigin.PARAMETER)
    }


@pytest.mark.parametrize(
    'pair', [([], [FRONT], [OTHER]), ([], [FRONT, OTHER], []), (['points'], [], [
        ObstacleSource('points', 'point_cloud', '/cloud')])]
)  # fmt: skip
def test_two_sources_of_one_name_with_other_keys_are_refused(pair):
    with pytest.raises(ArgumentError, match='with other keys: leave one of the two out'):
        all_sources(*pair)


def test_a_service_adds_no_second_source_of_a_name_and_removes_none_but_its_own():
    there = all_sources(['points'], [], [FRONT])
    for name, words in (('front', 'by the scene file'), ('points', 'by a parameter of the node')):
        with pytest.raises(ArgumentError, match=words):
            refuse_taken_name(ObstacleSource(name, 'laser_scan', '/a'), there)
        with pytest.raises(ArgumentError, match=words):
            removable(name, there)
    with pytest.raises(ArgumentError, match=r'there is none.*add_obstacle_source: none'):
        removable('moon', there)
    added = {**there, 'own': NamedSource(OTHER, SourceOrigin.SERVICE)}
    assert removable('own', added) == OTHER


def test_a_saved_scene_has_all_but_those_of_the_parameter_obstacles():
    assert saved_sources([POINTS, FRONT]) == (FRONT,)


def test_the_parameter_is_read_as_the_section_of_a_scene_file():
    assert obstacle_sources_of('  ') == ()
    assert obstacle_sources_of('{front: {type: laser_scan, topic: /scan}}') == (FRONT,)
    with pytest.raises(RuntimeError, match=r'^obstacle_sources:1: .*missing `topic`'):
        obstacle_sources_of('{front: {type: laser_scan}}')
