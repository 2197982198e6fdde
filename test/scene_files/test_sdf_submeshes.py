"""Parts of meshes that SDFormat names: which triangles, where, and as which shape."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES, dae, gltf

from drake_geom_ros.geometry import Convex, Mesh, Role
from drake_geom_ros.geometry.meshes._obj_file import obj_text
from drake_geom_ros.scene_files import RobotOptions, read_scene
from drake_geom_ros.scene_files.errors import SceneFileError

LOW, HIGH = np.array([0, 0, 0]), np.array([1, 2, 3])
FAR = '<translate>10 0 0</translate><instance_geometry url="#g"/>'
NEAR = '<instance_geometry url="#g"/>'


def obj():
    """Return two boxes, the second one 10 m along x; faces of the first come before and after."""
    points = obj_text(np.vstack((BOX, np.add(BOX, [10, 0, 0]))))
    first, second = (
        ''.join('f ' + ' '.join(map(str, side + 1 + shift)) + '\n' for side in SIDES)
        for shift in (0, 8)
    )
    half = len(first) // 2
    half = first.index('\n', half) + 1
    return f'{points}o near\n{first[:half]}g far box\n{second}o near\n{first[half:]}'


# By format: the content, and the middle of a box that is turned from y up in it.
FILES = {
    'obj': obj(),
    'dae': dae(nodes=f'<node name="near">{NEAR}</node><node name="far box">{FAR}</node>'),
    'gltf': gltf(
        [{'mesh': 0, 'name': 'near'}, {'mesh': 0, 'name': 'far box', 'translation': [10, 0, 0]}]
    ),
}


def written(folder, kind, inside, more=''):
    (folder / f'two.{kind}').write_text(FILES[kind])
    path = folder / 'm.sdf'
    path.write_text(
        '<sdf version="1.9"><model name="m"><link name="l"><collision name="c"><geometry><mesh>'
        f'<uri>two.{kind}</uri><submesh>{inside}</submesh>{more}</mesh></geometry></collision>'
        '</link></model></sdf>\n'
    )
    return path


def box_of(kind):
    """Return the corners of the box in a format: glTF is turned from y up to z up."""
    return (np.array([0, -3, 0]), np.array([1, 0, 2])) if kind == 'gltf' else (LOW, HIGH)


@pytest.mark.parametrize('kind', FILES)
@pytest.mark.parametrize(('name', 'shift'), [('near', 0), ('far box', 10)])
def test_a_part_is_the_triangles_of_its_name(tmp_path, kind, name, shift):
    (geometry,) = read_scene(written(tmp_path, kind, f'<name>{name}</name>')).geometries
    vertices, triangles = geometry.shape.surface()
    low, high = box_of(kind)
    assert (len(vertices), len(triangles)) == (8, 12)
    np.testing.assert_allclose(
        vertices.min(axis=0), np.add(low, [shift, 0, 0]), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        vertices.max(axis=0), np.add(high, [shift, 0, 0]), rtol=0, atol=1e-12
    )


def test_a_part_may_be_centred_scaled_and_convex(tmp_path):
    inside = '<name>far box</name><center>true</center>'
    path = written(tmp_path, 'obj', inside, '<scale>2 1 1</scale>')
    (geometry,) = read_scene(path).geometries
    vertices, _ = geometry.shape.surface()
    np.testing.assert_array_equal(vertices.min(axis=0), [-1, -1, -1.5])
    np.testing.assert_array_equal(vertices.max(axis=0), [1, 1, 1.5])
    path = written(tmp_path, 'obj', inside, '<drake:declare_convex/>')
    path.write_text(path.read_text().replace('<sdf ', '<sdf xmlns:drake="http://drake.mit.edu" '))
    (geometry,) = read_scene(path).geometries
    assert isinstance(geometry.shape, Convex)


def test_a_part_counts_as_its_hull_unless_it_is_chosen(tmp_path):
    path = written(tmp_path, 'obj', '<name>near</name>')
    for options, is_solid in ((RobotOptions(), False), (RobotOptions(solid_meshes=('l',)), True)):
        (geometry,) = read_scene(path, options=options).geometries
        assert isinstance(geometry.shape, Mesh)
        properties = geometry.roles[Role.kProximity]
        assert properties.GetPropertyOrDefault('mesh', 'solid', False) is is_solid


@pytest.mark.parametrize(
    ('inside', 'fault'),
    [
        ('', '<submesh> has no <name>'),
        ('<name>middle</name>', "has no part 'middle'; its parts are 'near', 'far box'"),
        ('<name>near</name><center>maybe</center>', "<center> is 'maybe'"),
    ],
)
def test_other_parts_are_refused_with_their_line(tmp_path, inside, fault):
    with pytest.raises(SceneFileError, match=f'm.sdf:1: .*{fault}'):
        read_scene(written(tmp_path, 'obj', inside))
