import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    IllustrationProperties,
    Mesh,
    MeshData,
    ProximityProperties,
    Rgba,
    Role,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from drake_geom_ros.scene_files.yaml_values import (
    plain_pose,
    plain_roles,
    plain_shape,
    pose_of,
    roles_of,
    shape_of,
)

ANGLES = st.floats(-math.pi, math.pi)
LENGTHS = st.floats(1e-6, 1e6)


def test_a_missing_pose_is_the_identity():
    assert pose_of(None).IsExactlyIdentity()
    assert pose_of({}).IsExactlyIdentity()
    assert plain_pose(RigidTransform()) == {}


def test_the_three_ways_to_say_a_rotation_agree():
    rpy = RollPitchYaw(0.1, 0.2, 0.3)
    wxyz = rpy.ToQuaternionAsVector()
    X = pose_of({'position': [1, 2, 3], 'rpy': [0.1, 0.2, 0.3]})
    assert X.IsExactlyEqualTo(RigidTransform(rpy, [1, 2, 3]))
    by_quaternion = pose_of({'position': [1, 2, 3], 'quaternion': np.roll(wxyz, -1).tolist()})
    assert by_quaternion.IsNearlyEqualTo(X, 1e-15)
    rows = X.rotation().matrix().tolist()
    assert pose_of({'position': [1, 2, 3], 'rotation': rows}).IsExactlyEqualTo(X)


@pytest.mark.parametrize(
    'plain',
    [{'quaternion': [0, 0, 0, 0]}, {'quaternion': [1, 1, 0, 0]}, {'rotation': [[1, 0, 0]] * 3}],
)
def test_what_does_not_rotate_is_refused(plain):
    with pytest.raises(RuntimeError, match=r'has norm|not a rotation'):
        pose_of(plain)


@given(ANGLES, ANGLES, ANGLES, st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3))
def test_no_digit_of_a_pose_is_lost(roll, pitch, yaw, p):
    X = RigidTransform(RollPitchYaw(roll, pitch, yaw), p)
    plain = plain_pose(X)
    assert pose_of(plain).IsExactlyEqualTo(X)
    assert plain_pose(pose_of(plain)) == plain


def test_a_pose_is_saved_as_a_quaternion_where_that_says_it_all():
    X = RigidTransform(RotationMatrix([[0, 1, 0], [0, 0, 1], [1, 0, 0]]))
    assert set(plain_pose(X)) == {'quaternion'}


def test_zeros_lose_their_sign():
    X = RigidTransform(RotationMatrix([[-1, -0.0, 0], [0, -1, -0.0], [-0.0, 0, 1]]), [-0.0, 1, 0])
    assert '-0.0' not in str(plain_pose(X))
    assert pose_of(plain_pose(X)).IsExactlyEqualTo(X)


SHAPES = st.one_of(
    st.builds(Sphere, st.just(0.0) | LENGTHS),
    st.builds(Box, LENGTHS, LENGTHS, LENGTHS),
    st.builds(Capsule, LENGTHS, LENGTHS),
    st.builds(Cylinder, LENGTHS, LENGTHS),
    st.builds(Ellipsoid, LENGTHS, LENGTHS, LENGTHS),
    st.builds(HalfSpace),
    st.builds(Convex, st.just('/a/b.obj'), LENGTHS),
    st.builds(Mesh, st.just('/a/b.obj'), st.tuples(LENGTHS, LENGTHS, st.just(-1.0))),
)


@given(SHAPES)
def test_a_shape_comes_back(shape):
    assert shape_of(plain_shape(shape), str, pytest.fail) == shape


def test_a_mesh_is_found_by_its_uri():
    plain = {'type': 'mesh', 'uri': 'package://p/m.obj'}
    assert shape_of(plain, lambda uri: f'/found/{uri[-5:]}', pytest.fail) == Mesh(
        '/found/m.obj', 1.0
    )


def test_a_shape_of_another_kind_has_no_form():
    class Torus(Shape):
        _TYPE = 99

    with pytest.raises(TypeError, match='Torus cannot be written'):
        plain_shape(Torus())


def test_without_an_entry_there_is_the_proximity_role_alone():
    (role,) = roles_of(None)
    assert role is Role.kProximity
    assert plain_roles(roles_of(None)) is None
    assert plain_roles({}) == {}
    assert roles_of({}) == {}


def test_properties_keep_their_values_and_types():
    proximity = ProximityProperties()
    values = {'a': True, 'b': 1, 'c': 1.0, 'd': 'text', 'e': [1, 1.5, 'x', False], 'f': []}
    for key, value in values.items():
        proximity.AddProperty('g', key, value)
    proximity.AddProperty('h', 'array', np.array([[1.0, 2.0], [3.0, 4.0]]))
    drawn = IllustrationProperties()
    drawn.AddProperty('phong', 'diffuse', Rgba(0.1, 0.2, 0.3, 0.4))
    roles = {Role.kIllustration: drawn, Role.kProximity: proximity}
    back = roles_of(plain_roles(roles))
    boxes = back[Role.kProximity].GetPropertiesInGroup('g')
    read = {name: box.get_value() for name, box in boxes.items()}
    assert read == values
    assert [type(value) for value in read.values()] == [type(value) for value in values.values()]
    array = back[Role.kProximity].GetProperty('h', 'array')
    np.testing.assert_array_equal(array, [[1, 2], [3, 4]])
    assert back[Role.kIllustration].GetProperty('phong', 'diffuse') == Rgba(0.1, 0.2, 0.3, 0.4)
    assert list(plain_roles(roles)) == ['proximity', 'illustration']


@pytest.mark.parametrize(
    'value',
    [math.inf, math.nan, 2**63, object(), np.array([1]), np.array([math.nan]), [[1]], None],
)
def test_a_property_that_the_format_cannot_say_is_refused(value):
    properties = ProximityProperties()
    properties.AddProperty('g', 'odd', value)
    with pytest.raises(TypeError, match="property 'odd'"):
        plain_roles({Role.kProximity: properties})


@pytest.mark.parametrize('kind', [Convex, Mesh])
def test_a_mesh_of_numbers_there_and_back(kind):
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    data = MeshData(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    shape = kind.FromMeshData(data, [1.0, 2.0, 0.5])
    assert shape_of(plain_shape(shape), str, pytest.fail) == shape
