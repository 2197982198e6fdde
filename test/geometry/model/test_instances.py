"""Frames and geometries before they are registered."""

import copy

import pytest

from drake_geom_ros.geometry import (
    GeometryFrame,
    GeometryInstance,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform

X = RigidTransform([1, 2, 3])


def test_frame():
    frame = GeometryFrame(frame_name=' hand\t', frame_group_id=3)
    assert frame.name() == 'hand'
    assert frame.frame_group() == 3
    assert GeometryFrame('a').frame_group() == 0
    assert frame.id() != GeometryFrame('hand').id()
    assert copy.copy(frame).id() == frame.id()


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('a', -1), 'frame_group_id = -1'),
        (('a', 1.5), 'frame_group_id = 1.5'),
        (('',), 'empty'),
        (('\t ',), 'empty'),
        ((3,), 'must be of type str'),
    ],
)
def test_bad_frames(arguments, words):
    with pytest.raises(RuntimeError, match=words):
        GeometryFrame(*arguments)


@pytest.mark.parametrize(
    ('given', 'canonical'),
    [(' ball', 'ball'), ('\t my ball \t', 'my ball'), ('\n', '\n'), ('ball\n ', 'ball\n')],
)
def test_names_are_trimmed_of_spaces_and_tabs_only(given, canonical):
    instance = GeometryInstance(X, Sphere(1), given)
    assert instance.name() == canonical
    instance.set_name('other')
    instance.set_name(given)
    assert instance.name() == canonical


def test_a_pose_whose_sums_would_leave_float64_is_refused():
    with pytest.raises(RuntimeError, match=r'X_PG lies at \[0.0, 1e\+308, 0.0\] m; .* beyond'):
        GeometryInstance(RigidTransform([0, 1e308, 0]), Sphere(1), 'ball')


def test_an_empty_name_is_refused_and_the_old_one_stays():
    with pytest.raises(RuntimeError, match='empty'):
        GeometryInstance(X, Sphere(1), ' \t')
    instance = GeometryInstance(X, Sphere(1), 'ball')
    with pytest.raises(RuntimeError, match='empty'):
        instance.set_name('')
    assert instance.name() == 'ball'


def test_instance():
    instance = GeometryInstance(X_PG=X, shape=Sphere(1), name='ball')
    assert instance.pose() == X
    assert instance.shape() == instance.release_shape() == Sphere(1)
    assert instance.id() != GeometryInstance(X, Sphere(1), 'ball').id()
    assert copy.copy(instance).id() == instance.id()
    instance.set_pose(RigidTransform())
    assert instance.pose().IsExactlyIdentity()


def test_the_pose_is_a_copy():
    mine = RigidTransform([1, 2, 3])
    instance = GeometryInstance(mine, Sphere(1), 'ball')
    mine.set_translation([9, 9, 9])
    instance.pose().set_translation([9, 9, 9])
    assert instance.pose() == X


@pytest.mark.parametrize(
    ('role', 'kind'),
    [
        ('proximity', ProximityProperties),
        ('illustration', IllustrationProperties),
        ('perception', PerceptionProperties),
    ],
)
def test_properties_of_each_role(role, kind):
    instance = GeometryInstance(X, Sphere(1), 'ball')
    read, change = (getattr(instance, f'{prefix}{role}_properties') for prefix in ('', 'mutable_'))
    assert read() is None
    assert change() is None
    properties = kind()
    getattr(instance, f'set_{role}_properties')(properties)
    properties.AddProperty('g', 'late', 1)
    change().AddProperty('g', 'n', 1)
    assert list(read().GetPropertiesInGroup('g')) == ['n']
    wrong = IllustrationProperties() if kind is ProximityProperties else ProximityProperties()
    with pytest.raises(RuntimeError, match=f'must be of type {kind.__name__}'):
        getattr(instance, f'set_{role}_properties')(wrong)


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        ((None, Sphere(1), 'a'), 'X_PG = None must be of type RigidTransform'),
        ((X, 'ball', 'a'), 'shape'),
        ((X, Sphere(1), 3), 'name'),
    ],
)
def test_wrong_kinds(arguments, words):
    with pytest.raises(RuntimeError, match=words):
        GeometryInstance(*arguments)


@pytest.mark.parametrize('copied', [copy.copy, copy.deepcopy])
@pytest.mark.parametrize(
    ('role', 'kind'),
    [
        ('proximity', ProximityProperties),
        ('illustration', IllustrationProperties),
        ('perception', PerceptionProperties),
    ],
)
def test_a_copy_has_properties_of_its_own(copied, role, kind):
    instance = GeometryInstance(X, Sphere(1), 'ball')
    getattr(instance, f'set_{role}_properties')(kind())
    other = copied(instance)
    getattr(other, f'mutable_{role}_properties')().AddProperty('a', 'b', 1)
    assert not getattr(instance, f'{role}_properties')().HasGroup('a')
    assert (other.id(), other.pose(), other.shape()) == (instance.id(), X, Sphere(1))
    other.set_pose(RigidTransform())
    other.set_name('other')
    assert (instance.pose(), instance.name()) == (X, 'ball')


@pytest.mark.parametrize('name', ['a\0b', '\0'])
def test_a_name_that_messages_would_cut_is_refused(name):
    """A string of a message ends at its first NUL: two such names would be one."""
    scene_graph = SceneGraph()
    with pytest.raises(RuntimeError, match='NUL'):
        scene_graph.RegisterSource(name)
    with pytest.raises(RuntimeError, match='NUL'):
        GeometryFrame(name)
    with pytest.raises(RuntimeError, match='NUL'):
        GeometryInstance(RigidTransform(), Sphere(1.0), name)
