"""Parameters: what may be given, in which form, and what is said of the rest."""

import math

import pytest
import rclpy
from rclpy.parameter import Parameter
from ros.harness import environment

from drake_geom_ros.ros.parameters import NodeParameters, ParameterRefusedError, ParameterStore

pytestmark = pytest.mark.topics


@pytest.fixture
def start(monkeypatch):
    """Return a function that declares the parameters with overrides on a node of its own."""
    name = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
    monkeypatch.setenv(name, environment()[name])
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=int(environment()['ROS_DOMAIN_ID']))
    nodes = []

    def declare(on_change=lambda old, new: None, **overrides):
        given = [
            value if isinstance(value, Parameter) else Parameter(name, value=value)
            for name, value in overrides.items()
        ]
        node = rclpy.create_node('p', context=context, parameter_overrides=given)
        nodes.append(node)
        return node, ParameterStore(node, on_change)

    yield declare
    for node in nodes:
        node.destroy_node()
    context.try_shutdown()


def put(node, name, value):
    return node.set_parameters([Parameter(name, value=value)])[0]


def test_the_defaults(start):
    assert start()[1].values == NodeParameters()


def test_a_whole_number_stands_for_a_float(start):
    node, store = start(max_distance=1, rate=100)
    values = store.values
    assert (values.max_distance, values.rate) == (1.0, 100.0)
    assert {type(values.max_distance), type(values.rate)} == {float}
    assert put(node, 'max_distance', 2).successful
    assert store.values.max_distance == 2.0
    assert type(store.values.max_distance) is float


def test_no_roots_at_all(start):
    """``-p mesh_roots:=[]`` has no type, for nothing in it has one."""
    nothing = Parameter('mesh_roots', Parameter.Type.NOT_SET, None)
    node, store = start(mesh_roots=nothing)
    assert store.values.mesh_roots == ()
    assert put(node, 'mesh_roots', ['here']).successful
    assert store.values.mesh_roots == ('here',)
    # `ros2 param set` sends an empty list as one of truth values.
    empty = Parameter('mesh_roots', Parameter.Type.BOOL_ARRAY, [])
    assert node.set_parameters([empty])[0].successful
    assert store.values.mesh_roots == ()


@pytest.mark.parametrize(
    ('name', 'value', 'words'),
    [
        ('max_distance', 'far', "max_distance is 'far'; it must be a number"),
        ('max_distance', True, 'max_distance is True; it must be a number'),
        ('max_distance', -1, 'max_distance is -1.0; it must lie in [0.0, inf]'),
        ('max_distance', math.nan, 'max_distance is nan; it must lie in'),
        ('mesh_roots', 'here', "mesh_roots is 'here'; it must be a list of texts"),
        ('mesh_roots', [1, 2], 'mesh_roots is (1, 2); it must be a list of texts'),
        ('publish_markers', 1, 'publish_markers is 1; it must be true or false'),
        ('replay_limit', 2.0, 'replay_limit is 2.0; it must be a whole number'),
        ('replay_limit', -2, 'replay_limit is -2; it must lie in [0, 10000]'),
        ('scene_file', 3, 'scene_file is 3; it must be a text'),
        ('accuracy', 'best', "accuracy='best' was asked for; it must be one of bound, fast"),
        ('world_frame', '/map', "world_frame is '/map'"),
        ('cross_check', -1, 'cross_check is -1.0; it must lie in [0.0, 1000.0]'),
        ('rate', 1e-12, 'rate is 1e-12; it must be 0 or lie in [0.001, 10000.0]'),
    ],
)
def test_what_cannot_be_is_refused_at_the_start(start, name, value, words):
    with pytest.raises(ParameterRefusedError) as caught:
        start(**{name: value})
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ('name', 'value', 'words'),
    [
        ('rate', 'fast', 'it must be a number'),
        ('rate', -1, 'it must lie in [0.0, 10000.0]'),
        ('rate', 1e6, '10000.0'),
        ('rate', 1e-12, 'rate is 1e-12; it must be 0 or lie in [0.001, 10000.0]'),
        ('cross_check', 5e-324, 'it must be 0 or lie in [0.001, 1000.0]'),
        ('max_distance', None, 'it must be a number'),
        ('accuracy', 'x', 'bound, fast, balanced, exact'),
        ('publish_markers', 1, 'publish_markers is 1; it must be true or false'),
        ('mesh_roots', [1], 'it must be a list of texts'),
        ('mesh_roots', None, 'it must be a list of texts'),
        ('scene_file', 'other.yaml', 'read-only'),
    ],
)
def test_what_cannot_be_is_refused_while_it_runs(start, name, value, words):
    node, store = start()
    changes = []
    store._on_change = lambda *both: changes.append(both)
    result = put(node, name, value)
    assert not result.successful
    assert words in result.reason
    assert (store.values, changes) == (NodeParameters(), [])


def test_a_second_opinion_needs_somebody_to_give_it(start, monkeypatch):
    monkeypatch.setattr('drake_geom_ros.cross_check.asker.find_spec', lambda name: None)
    with pytest.raises(ParameterRefusedError, match='cross_check needs python-fcl'):
        start(cross_check=1.0)
    node, _ = start()
    assert 'pip install python-fcl' in put(node, 'cross_check', 1.0).reason


def test_where_nothing_may_be_written_there_are_no_replays(start):
    with pytest.raises(ParameterRefusedError, match=r'replay_dir .* allow_writes'):
        start(replay_dir='/tmp/replays', allow_writes=False)
    node, _ = start(allow_writes=False)
    result = put(node, 'replay_dir', '/tmp/replays')
    assert not result.successful
    assert 'allow_writes' in result.reason
    # Who may set parameters must not be able to allow it.
    assert not put(node, 'allow_writes', True).successful


def test_a_box_is_six_numbers_in_order(start):
    node, store = start(obstacle_box=[-1, -1, 0, 1, 1, 2])
    assert store.values.obstacle_box == (-1.0, -1.0, 0.0, 1.0, 1.0, 2.0)
    for wrong in ([1.0], [0.0] * 6, [0.0, 0.0, 0.0, 1.0, 1.0, float('nan')], ['a'] * 6):
        assert not put(node, 'obstacle_box', wrong).successful
        assert 'obstacle_box is' in put(node, 'obstacle_box', wrong).reason
    assert put(node, 'obstacle_box', [-1.0, -1.0, 0.0, float('inf'), 1.0, 2.0]).successful
    nothing = Parameter('obstacle_box', Parameter.Type.NOT_SET, None)
    assert start(obstacle_box=nothing)[1].values.obstacle_box == ()
