import pytest

from drake_geom_ros.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, Mesh, Sphere
from drake_geom_ros.scene_files.description import RobotOptions
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.urdf import read_urdf
from drake_geom_ros.scene_files.urdf_shapes import KNOWN_SHAPES


def robot(shape):
    return (
        '<robot name="r" xmlns:drake="d"><link name="a"><visual/><collision><geometry>'
        f'{shape}</geometry></collision></link></robot>'
    )


def shape(text, folder):
    data = robot(text).encode()
    parts = read_urdf(data, 'r.urdf', 'r', folder, ResourceResolver(), RobotOptions())
    return parts.geometries[0].shape


@pytest.mark.parametrize(
    ('given', 'expected'),
    [
        ('<capsule radius="1" length="2"/>', Capsule(1, 2)),
        ('<drake:capsule radius="1" length="2"/>', Capsule(1, 2)),
        ('<cylinder radius="1" length="2"/>', Cylinder(1, 2)),
        ('<drake:ellipsoid a="1" b="2" c="3"/>', Ellipsoid(1, 2, 3)),
        ('<box size=" 1 2\t3 "/>', Box(1, 2, 3)),
        ('<sphere radius="1e-1"/>', Sphere(0.1)),
    ],
)
def test_shapes(tmp_path, given, expected):
    assert shape(given, tmp_path) == expected


def test_an_ellipsoid_needs_all_its_axes(tmp_path):
    with pytest.raises(SceneFileError, match='has no attribute `b`'):
        shape('<drake:ellipsoid a="1"/>', tmp_path)


def test_the_message_about_unknown_shapes_lists_those_that_are_read(tmp_path):
    with pytest.raises(SceneFileError) as caught:
        shape('<torus/>', tmp_path)
    assert str(caught.value).endswith(', '.join(KNOWN_SHAPES))


@pytest.mark.parametrize(
    ('inside', 'kind'),
    [('', Mesh), ('<drake:declare_convex/>', Convex), ('<declare_convex/>', Convex)],
)
def test_a_mesh_is_convex_where_it_is_declared_so(tmp_path, inside, kind):
    (tmp_path / 'm.obj').write_text('v 0 0 0')
    expected = kind(str(tmp_path / 'm.obj'), 1.0)
    assert shape(f'<mesh filename="m.obj">{inside}</mesh>', tmp_path) == expected


def test_a_declaration_beside_the_mesh_says_nothing_as_in_drake(tmp_path):
    (tmp_path / 'm.obj').write_text('v 0 0 0')
    inside = '<mesh filename="m.obj"/><drake:declare_convex/>'
    assert shape(inside, tmp_path) == Mesh(str(tmp_path / 'm.obj'), 1.0)


def test_one_scale_is_for_all_axes(tmp_path):
    (tmp_path / 'm.obj').write_text('v 0 0 0')
    expected = Mesh(str(tmp_path / 'm.obj'), 0.001)
    assert shape('<mesh filename="m.obj" scale="0.001"/>', tmp_path) == expected


@pytest.mark.parametrize('scale', ['0 1 1', '1 2', 'x'])
def test_a_bad_scale_is_refused(tmp_path, scale):
    (tmp_path / 'm.obj').write_text('v 0 0 0')
    with pytest.raises(SceneFileError, match=r'r\.urdf:1: link\[a\]'):
        shape(f'<mesh filename="m.obj" scale="{scale}"/>', tmp_path)
