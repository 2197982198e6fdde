"""Edges of paths: a floating base, kilometres, margins, filters, no pose, contact at the end."""

import math

import numpy as np
import pytest
from batch.test_paths import ROD, SCENE

from drake_geom_ros.batch import Joints, check_path
from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    PoseError,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene

FLOATING = """<robot name="cart">
  <link name="root"/>
  <link name="body"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="arm"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry>
  </collision></link>
  <link name="hand"><collision><origin xyz="1.5 0 0"/><geometry><sphere radius="0.1"/></geometry>
  </collision></link>
  <joint name="base" type="KIND"><parent link="root"/><child link="body"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="turn" type="continuous"><parent link="body"/><child link="arm"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="1" velocity="1" effort="1"/></joint>
</robot>
"""
FAR = """name: far
sources: [posts]
robots: [{name: cart, urdf: cart.urdf, adjacent_links: kept}]
geometries:
  - {name: post, source: posts, pose: {position: [1000, 0, 0]}, shape: {type: sphere, radius: 0.1}}
"""


def cart(folder, kind):
    """Return a scene of an arm on a base that moves by joints, and a post a kilometre away."""
    (folder / 'cart.urdf').write_text(FLOATING.replace('KIND', kind))
    (folder / 'scene.yaml').write_text(FAR)
    graph = SceneGraph()
    return graph, Joints.of(load_scene(folder / 'scene.yaml', graph))


def row(joints, **values):
    """Return a row of joint values, 0 where none is given."""
    named = {f'cart::{name.replace("_", "/")}': value for name, value in values.items()}
    assert set(named) <= set(joints.names)
    return [named.get(name, 0.0) for name in joints.names]


@pytest.mark.parametrize('kind', ['planar', 'floating'])
def test_a_base_that_moves_for_kilometres(tmp_path, kind):
    graph, joints = cart(tmp_path, kind)
    turned = 'base_theta' if kind == 'planar' else 'base_yaw'
    start, end = row(joints), row(joints, base_x=2000.0)
    check = check_path(graph, joints, [start, end], time_tolerance=1e-10)
    # The hand, 1.5 m ahead, comes to the post by 0.2 m.
    assert check.outcome == 'contact'
    assert check.times[0] <= (1000.0 - 1.5 - 0.2) / 2000.0 <= check.times[1]
    aside = check_path(
        graph, joints, [row(joints, base_y=0.3), row(joints, base_x=2000, base_y=0.3)]
    )
    assert aside.outcome == 'clear'
    assert 0.0 < aside.lower_bound <= 0.1
    # A whole turn of the base at the post's side: the hand meets it at the angle of a chord.
    at = {'base_x': 1000.0, 'base_y': 1.5}
    whole = check_path(
        graph, joints, [row(joints, **at), row(joints, **at, **{turned: 2 * math.pi})]
    )
    assert whole.outcome == 'contact'
    first = (1.5 * math.pi - 2 * math.asin(0.2 / 2 / 1.5)) / (2 * math.pi)
    assert whole.times[0] <= first <= whole.times[1]


def test_links_that_move_together_are_looked_at_once(tmp_path):
    """The base goes far and turns over, which moves no link against another one."""
    graph, joints = cart(tmp_path, 'floating')
    start = row(joints, base_y=50.0, slide=0.05)
    end = row(joints, base_x=300.0, base_y=50.0, base_roll=2.0, base_yaw=3.0, slide=0.05)
    check = check_path(graph, joints, [start, end])
    assert check.outcome == 'clear'
    assert check.evaluations <= 3  # one for each pair of its three links
    assert check.lower_bound > 0.0


def test_contact_at_the_very_end_and_a_hair_before_it(pillar_of):
    graph, joints = pillar_of()
    angle = 0.5 * math.pi - 2 * math.asin(0.1)
    for hair, outcomes in (
        (-1e-9, {'clear'}),
        (0.0, {'clear', 'unknown', 'contact'}),
        (1e-9, {'contact'}),
    ):
        check = check_path(graph, joints, [[0.0, 0.0], [angle + hair, 0.0]])
        assert check.outcome in outcomes
        assert check.last_free > 1.0 - 2e-6


@pytest.fixture
def pillar_of(tmp_path):
    """Return what loads the scene of the rod and the post, changed."""

    def load(*changes):
        text = SCENE
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / 'rod.urdf').write_text(ROD)
        (tmp_path / 'scene.yaml').write_text(text)
        graph = SceneGraph()
        return graph, Joints.of(load_scene(tmp_path / 'scene.yaml', graph))

    return load


def test_paddings_of_both_are_part_of_bodies(pillar_of):
    padded = (
        'radius: 0.1}}',
        'radius: 0.1}, roles: {proximity: {proximity: {padding: 0.05}}}}',
    )
    robot = 'adjacent_links: kept}', 'adjacent_links: kept, padding: 0.03}'
    for changes, reach in (((), 0.2), ((padded,), 0.25), ((padded, robot), 0.28)):
        graph, joints = pillar_of(*changes)
        check = check_path(graph, joints, [[0.0, 0.0], [0.5 * math.pi, 0.0]])
        first = (0.5 * math.pi - 2 * math.asin(0.5 * reach)) / (0.5 * math.pi)
        assert check.outcome == 'contact'
        assert check.times[0] <= first <= check.times[1]


def test_filters_hold(pillar_of):
    graph, joints = pillar_of()
    path = [[0.0, 0.0], [math.pi, 0.0]]
    assert check_path(graph, joints, path).outcome == 'contact'
    everything = GeometrySet(geometry_ids=graph.model_inspector().GetAllGeometryIds())
    context = graph.CreateDefaultContext()
    declaration = CollisionFilterDeclaration().ExcludeWithin(everything)
    graph.collision_filter_manager(context).Apply(declaration)
    with pytest.raises(ArgumentError, match='filters leave all of it out'):
        check_path(context, joints, path)
    assert check_path(graph.CreateDefaultContext(), joints, path).outcome == 'contact'


def test_a_frame_that_never_had_a_pose_is_told(pillar_of):
    graph, joints = pillar_of()
    source = graph.RegisterSource('late')
    frame = graph.RegisterFrame(source, GeometryFrame('late'))
    body = GeometryInstance(RigidTransform(), Sphere(0.1), 'late')
    body.set_proximity_properties(ProximityProperties())
    graph.RegisterGeometry(source, frame, body)
    with pytest.raises(PoseError, match='never had a pose'):
        check_path(graph, joints, [[0.0, 0.0]])


@pytest.mark.parametrize(
    ('asked', 'word'),
    [
        ({'min_distance': math.nan}, 'min_distance'),
        ({'min_distance': -1e-3}, 'min_distance'),
        ({'time_tolerance': math.nan}, 'time_tolerance'),
        ({'bound_tolerance': 0.0}, 'bound_tolerance'),
        ({'max_evaluations': -1}, 'max_evaluations'),
        ({'accuracy': 'best'}, 'accuracy'),
        ({'threads': -1}, 'threads'),
    ],
)
def test_what_cannot_be_asked_is_refused(pillar_of, asked, word):
    graph, joints = pillar_of()
    with pytest.raises(ArgumentError, match=word):
        check_path(graph, joints, np.zeros((2, 2)), **asked)
