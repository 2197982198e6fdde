"""URDF and SRDF files as people have them: names, first characters, other formats, macros."""

import sys

import pytest
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import SceneFileError, load_scene, read_scene
from drake_geom_ros.trajectories.kinematics import Kinematics

BALL = """<robot name="r"{}>
<link name="a"><collision><geometry><sphere radius="{}"/></geometry></collision></link>
<link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint></robot>"""
URDF = BALL.format('', '2')
XACRO = ' xmlns:xacro="http://www.ros.org/wiki/xacro"'
MACROS = BALL.format(XACRO, '${2 * s}').replace(
    '<link', '<xacro:include filename="size.xacro"/>\n<link', 1
)
SIZE = f'<robot{XACRO}><xacro:property name="s" value="1"/></robot>'
POINTER = 'version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 9\n'


@pytest.mark.parametrize(
    'name', ['r.urdf', 'R.URDF', 'robot.xml', 'r.urdf.xacro', 'robot_description', 'r.yaml']
)
@pytest.mark.parametrize('start', ['', '\n  <?xml version="1.0"?>\n', '\ufeff', '<!-- a -->'])
def test_a_urdf_is_known_by_its_first_characters(tmp_path, name, start):
    (tmp_path / name).write_text(start + URDF)
    scene = read_scene(tmp_path / name)
    assert scene.geometries[0].shape.radius() == 2.0
    assert scene.geometries[0].where.line == 2 + start.count('\n')
    assert read_scene(f'{start}{URDF}\n').sources == ('r',)


def test_a_default_namespace_and_other_encodings_are_fine(tmp_path):
    (tmp_path / 'a.urdf').write_text(BALL.format(' xmlns="http://www.ros.org"', '2'))
    for encoding in ('utf-16', 'iso-8859-1'):
        text = f'<?xml version="1.0" encoding="{encoding}"?>{URDF}'.replace('"b"', '"bé"')
        (tmp_path / f'{encoding}.urdf').write_bytes(text.encode(encoding))
        assert read_scene(tmp_path / f'{encoding}.urdf').frames[1].name == 'bé'
    assert len(read_scene(tmp_path / 'a.urdf').frames) == 2


@pytest.mark.parametrize(
    ('name', 'text', 'told'),
    [
        ('M.STL', 'solid x\n', r"M.STL: .*M.STL' cannot be read: .*endsolid"),
        ('w.sdf', '<sdf version="1.7"/>', r'w.sdf:1: there is neither a <model> nor'),
        ('m.xml', '\n<mujocoinclude/>', r'm.xml:2: .*a part of MJCF; load the model'),
        ('r.urdf', POINTER, r'r.urdf: it is a Git LFS pointer.*git lfs pull'),
        ('r.yaml', POINTER, r'r.yaml: it is a Git LFS pointer'),
        ('r.urdf', '', r'r.urdf: it is empty'),
        ('r.html', '<!DOCTYPE html><html/>', r'r.html: it is a web page'),
        ('r.urdf', '\n\n<robot', r'r.urdf:3: not XML'),
    ],
)
def test_other_files_are_told_for_what_they_are(tmp_path, name, text, told):
    (tmp_path / name).write_text(text)
    with pytest.raises(SceneFileError, match=told):
        read_scene(tmp_path / name)


@pytest.mark.parametrize(
    ('name', 'text'), [('r.urdf', URDF), ('r.yaml', 'frames:\n- {name: b}\n- {name: a}')]
)
def test_bytes_that_are_not_utf_8_are_named_with_their_line(tmp_path, name, text):
    (tmp_path / name).write_bytes(text.replace('name: b', 'name: é').encode('latin-1'))
    if name == 'r.urdf':
        (tmp_path / name).write_bytes(text.replace('"b"', '"é"').encode('latin-1'))
    line = 3 if name == 'r.urdf' else 2
    with pytest.raises(SceneFileError, match=rf'{name}:{line}: .*byte 0xe9 is not UTF-8'):
        read_scene(tmp_path / name)


ORIGIN = '<robot name="r">\n<link name="a"><collision>{}<geometry>{}</geometry></collision>'
SPHERE, MESH = '<sphere radius="1"/>', '<mesh filename="t.obj" scale="{}"/>'


@pytest.mark.parametrize(
    ('origin', 'shape', 'told'),
    [
        ('<origin rpy=""/>', SPHERE, "rpy = '' must be 3 numbers"),
        ('<origin xyz="nan 0 0"/>', SPHERE, "origin: xyz = 'nan 0 0'; all numbers must be finite"),
        ('<origin xyz="1,2,3"/>', SPHERE, "xyz = '1,2,3' must be 3 numbers, .*without commas"),
        ('', '<sphere radius="0,5"/>', "radius = '0,5' must be a number, a point for decimals"),
        ('', MESH.format('1,1,1'), "scale = '1,1,1' must be 3 numbers, .*without commas"),
        ('', MESH.format('1 nan 1'), 'finite'),
        ('', MESH.format(''), "scale = '' must be 3 numbers"),
        ('', '<box size=""/>', "size = '' must be 3 numbers"),
    ],
)
def test_numbers_that_are_none_are_told_with_their_place(tmp_path, origin, shape, told):
    (tmp_path / 't.obj').write_text(TETRAHEDRON)
    path = tmp_path / 'r.urdf'
    path.write_text(ORIGIN.format(origin, shape) + '</link></robot>')
    with pytest.raises(SceneFileError, match=rf'r.urdf:2: link\[a\].collision: .*{told}'):
        load_scene(path, SceneGraph())


@pytest.fixture
def macros(tmp_path):
    (tmp_path / 'r.urdf.xacro').write_text(MACROS)
    (tmp_path / 'size.xacro').write_text(SIZE)
    (tmp_path / 'cell.yaml').write_text('robots: [{name: arm, urdf: r.urdf.xacro}]')
    return tmp_path


@pytest.mark.parametrize('name', ['r.urdf.xacro', 'cell.yaml'])
def test_macros_are_refused_with_the_way_out_without_xacro(macros, name, monkeypatch):
    monkeypatch.setitem(sys.modules, 'xacro', None)
    monkeypatch.setattr('drake_geom_ros.scene_files.robot_files.find_spec', lambda name: None)
    with pytest.raises(SceneFileError, match=r'r.urdf.xacro:.*is xacro: run xacro first \(`xacro'):
        read_scene(macros / name)


@pytest.mark.parametrize('name', ['r.urdf.xacro', 'cell.yaml'])
def test_macros_are_expanded_where_xacro_is(macros, name, capsys):
    pytest.importorskip('xacro')
    scene = read_scene(macros / name)
    assert scene.geometries[0].shape.radius() == 2.0
    assert Kinematics(str(scene.robots[0].urdf)).link_names == ('a', 'b')
    assert capsys.readouterr().out == ''


@pytest.mark.parametrize('name', ['r.urdf.xacro', 'cell.yaml'])
def test_macros_of_others_are_never_expanded(macros, name):
    """Xacro opens any file and computes: not for what comes with folders that may be opened."""
    with pytest.raises(SceneFileError, match='is xacro: run xacro first'):
        read_scene(macros / name, allowed_roots=[macros])


def test_what_xacro_refuses_is_told_in_one_line(macros):
    pytest.importorskip('xacro')
    (macros / 'size.xacro').unlink()
    with pytest.raises(SceneFileError, match=r'r.urdf.xacro: xacro cannot expand it: ') as told:
        read_scene(macros / 'r.urdf.xacro')
    assert '\n' not in str(told.value)
