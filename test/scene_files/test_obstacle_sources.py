"""Obstacle sources in scene files: read, refused with a line, written down and read again."""

import pytest

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import (
    ObstacleSource,
    SceneFileError,
    SourceQos,
    load_scene,
    obstacle_source_of_text,
    obstacle_source_text,
    obstacle_sources_of_text,
    read_scene,
    to_yaml,
)

SCENE = """
geometries: [{name: floor, shape: {type: half_space}}]
obstacle_sources:
  front_scan: {type: laser_scan, topic: /scan, extrude: [0, 1.8], timeout: 0.5, range: 8}
  rear_scan: {type: laser_scan, topic: rear/scan, frame: rear_lidar, required: false}
  wrist: {type: point_cloud, topic: /wrist, padding: {default: 0.05, "mm::wrist": 0.02}}
  camera:
    type: depth_image
    topic: /camera/depth/image_rect_raw
    resolution: 0.05
    box: [-2, -2, 0, 2, 2, 2]
    keep: 2
    rays: true
    noise: 0.02
    padding: 0.1
    least_points: 3
  world: {type: octomap, topic: ~/world, qos: {reliability: reliable, durability: transient_local}}
"""


def test_each_key_is_read():
    front, rear, wrist, camera, world = read_scene(SCENE).obstacle_sources
    assert front == ObstacleSource(
        'front_scan', 'laser_scan', '/scan', timeout=0.5, range=8, extrude=(0.0, 1.8)
    )
    assert rear == ObstacleSource(
        'rear_scan', 'laser_scan', 'rear/scan', frame='rear_lidar', required=False
    )
    assert wrist == ObstacleSource(
        'wrist', 'point_cloud', '/wrist', padding=0.05, paddings=(('mm::wrist', 0.02),)
    )
    assert camera == ObstacleSource(
        'camera',
        'depth_image',
        '/camera/depth/image_rect_raw',
        resolution=0.05,
        box=(-2.0, -2.0, 0.0, 2.0, 2.0, 2.0),
        keep=2,
        rays=True,
        noise=0.02,
        padding=0.1,
        least_points=3,
    )
    qos = SourceQos('reliable', 'transient_local')
    assert world == ObstacleSource('world', 'octomap', '~/world', qos=qos)


def test_what_is_written_is_read_again():
    scene = read_scene(SCENE)
    assert read_scene(to_yaml(scene)) == scene


@pytest.mark.parametrize(
    ('line', 'reason'),
    [
        ('a: {type: sonar, topic: /a}', 'sonar'),
        ('a: {type: laser_scan}', 'missing `topic`'),
        ('a: {type: laser_scan, topic: "two words"}', 'two words.*a topic is called'),
        ('a: {type: laser_scan, topic: /a, rate: 5}', 'rate'),
        ('a: {type: laser_scan, topic: /a, timeout: 0}', 'timeout'),
        ('a: {type: laser_scan, topic: /a, extrude: [1, 1]}', 'lowest and the highest height'),
        ('a: {type: laser_scan, topic: /a, box: [0, 0, 0, 1, 1, 0]}', 'each of the first three'),
        (
            'a: {type: octomap, topic: /a, keep: 1}',
            'keep is for laser_scan, .*range, and a is',
        ),
        ('a: {type: octomap, topic: /a, qos: {depth: 0}}', 'depth'),
        (
            'a: {type: laser_scan, topic: /a, may_be_empty: true}',
            'is for point_cloud, depth_image',
        ),
        ('a: {type: laser_scan, topic: /a, sensor: b}', 'sensor is for point_cloud'),
        ('a: {type: octomap, topic: /a, threshold: 50}', 'threshold is for occupancy_grid'),
        ('a: {type: occupancy_grid, topic: /a, threshold: 0}', 'threshold'),
        ('a: {type: occupancy_grid, topic: /a, unknown: maybe}', 'unknown'),
        ('a: {type: laser_scan, topic: /a, padding: {}}', 'padding'),
        ('a: {type: laser_scan, topic: /a, padding: {wrist: -1}}', '-1 must be >= 0'),
        ('a: {type: laser_scan, topic: /a, padding: wide}', 'must be a number or a mapping'),
        (
            'a: {type: octomap, topic: /a, padding: {wrist: 0.1}}',
            'padding is for laser_scan',
        ),
        ('a: {type: octomap, topic: /a, qos: {reliability: maybe}}', 'reliable, best_effort'),
        ('file: {type: laser_scan, topic: /a}', 'load_obstacles'),
    ],
)
def test_what_is_no_source_is_refused_with_its_line(line, reason):
    with pytest.raises(SceneFileError, match=reason) as refused:
        read_scene(f'sources: [s]\nobstacle_sources:\n  {line}\n')
    assert refused.value.line == 3


def test_a_text_of_sources_is_read_as_the_section_of_a_scene_file():
    section = SCENE.partition('obstacle_sources:')[2]
    every = obstacle_sources_of_text(section, 'parameter')
    assert every == read_scene(SCENE).obstacle_sources
    for each in every:
        assert obstacle_source_of_text(each.name, obstacle_source_text(each), 'request') == each


@pytest.mark.parametrize(
    ('name', 'settings', 'reason'),
    [
        ('a', '{type: laser_scan}', '^request:1: obstacle_sources.a: missing `topic`'),
        (
            'a',
            '{type: octomap,\n topic: /a,\n keep: 1}',
            '^request:3: .*keep is for laser',
        ),
        ('a b', '{type: octomap, topic: /a}', "'a b': a source is called by a letter"),
        ('file', '{type: octomap, topic: /a}', 'load_obstacles'),
        ('a', '', 'is empty'),
        ('a', '7', 'must be a mapping'),
        ('a', 'topic', 'must be a mapping'),
    ],
)
def test_a_text_that_is_no_source_is_refused_with_its_line(name, settings, reason):
    with pytest.raises(SceneFileError, match=reason):
        obstacle_source_of_text(name, settings, 'request')


def test_a_name_that_no_frame_may_have_is_refused():
    with pytest.raises(SceneFileError, match="'a::b': a source is called by a letter"):
        read_scene('obstacle_sources:\n  "a::b": {type: laser_scan, topic: /a}\n')


def test_who_makes_no_maps_says_so(tmp_path, capsys):
    with pytest.warns(
        UserWarning, match='front_scan, rear_scan, wrist, camera, world.*in any answer'
    ):
        load_scene(SCENE, SceneGraph())
    file = tmp_path / 'scene.yaml'
    file.write_text(SCENE)
    assert main(['query', str(file), '--what', 'least']) == 0
    assert 'warning: ' in capsys.readouterr().err


def test_a_static_map_is_taken_latched_unless_its_policies_say_otherwise():
    (static,) = obstacle_sources_of_text(
        '{m: {type: occupancy_grid, topic: /map, static: true}}', 't'
    )
    assert static.qos == ('reliable', 'transient_local', None)
    text = '{m: {type: octomap, topic: /map, static: true, qos: {depth: 2}}}'
    (own,) = obstacle_sources_of_text(text, 't')
    assert own.qos == (None, None, 2)


@pytest.mark.parametrize(
    ('keys', 'reason'),
    [
        ('type: occupancy_grid, static: true, timeout: 2', 'a static map never grows old'),
        ('type: laser_scan, static: true', 'static is for octomap, occupancy_grid'),
    ],
)
def test_a_sensor_and_what_grows_old_are_not_static(keys, reason):
    with pytest.raises(SceneFileError, match=reason):
        obstacle_sources_of_text(f'{{m: {{topic: /m, {keys}}}}}', 't')
