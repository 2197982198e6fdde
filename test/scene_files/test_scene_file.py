from pathlib import Path

import pytest
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import scene_file
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.scene_file import load_scene, read_scene, save_scene

TEXT = 'geometries:\n- {name: floor, shape: {type: half_space}}\n'
URDF = """<robot name="arm">
<link name="a"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<link name="b"><collision><geometry><mesh filename="package://parts/m.obj"/></geometry></collision>
</link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
</robot>"""
SRDF = '<robot name="arm">\n<disable_collisions link1="a" link2="b"/></robot>'


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'scene.yaml').write_text(TEXT)
    (tmp_path / 'arm.urdf').write_text(URDF)
    (tmp_path / 'arm.srdf').write_text(SRDF)
    (tmp_path / 'parts').mkdir()
    (tmp_path / 'parts' / 'm.obj').write_text(TETRAHEDRON)
    return tmp_path


def test_a_path_and_a_text_are_told_apart(folder):
    in_one_line = '{geometries: [{name: floor, shape: {type: half_space}}]}'
    for given in (folder / 'scene.yaml', str(folder / 'scene.yaml'), TEXT, in_one_line):
        assert [g.name for g in read_scene(given).geometries] == ['floor']


@pytest.mark.parametrize('format', ['', 'urdf'])
@pytest.mark.parametrize('as_text', [False, True])
def test_a_urdf_alone_is_a_scene_of_one_robot(folder, format, as_text):
    path = folder / 'arm.urdf'
    given = path.read_text() if as_text else path
    scene = read_scene(given, format, package_roots=[folder])
    (robot,) = scene.robots
    assert robot.urdf == (None if as_text else path)
    assert robot.X_WB.IsExactlyIdentity()
    assert scene.sources == ('arm',)
    assert len(scene.filters) == 1


@pytest.mark.parametrize('as_text', [False, True])
def test_an_srdf_goes_with_a_urdf(folder, as_text):
    srdf = SRDF if as_text else folder / 'arm.srdf'
    scene = read_scene(folder / 'arm.urdf', srdf=srdf, package_roots=[folder])
    assert len(scene.filters) == 2
    assert scene.robots[0].srdf == (None if as_text else srdf)


def test_load_and_save(folder):
    scene_graph = SceneGraph()
    loaded = load_scene(folder / 'arm.urdf', scene_graph, package_roots=[folder])
    assert set(loaded.frames) == {('arm', 'a'), ('arm', 'b')}
    text = save_scene(scene_graph, robots=loaded.robots.values())
    again = load_scene(text, SceneGraph())
    assert again.robots['arm'].urdf == folder / 'arm.urdf'
    assert set(again.geometries) == set(loaded.geometries)


def test_a_robot_that_came_as_text_is_saved_without_its_urdf(folder):
    scene_graph = SceneGraph()
    loaded = load_scene(URDF, scene_graph, package_roots=[folder])
    assert 'robots:' not in save_scene(scene_graph, robots=loaded.robots.values())


@pytest.mark.parametrize(
    ('given', 'options', 'message'),
    [
        ('none.yaml', {}, 'none.yaml: cannot be read: No such file or directory'),
        ('.', {}, '.: cannot be read: Is a directory'),
        (
            TEXT,
            {'format': 'stl'},
            "<text>: format 'stl' must be one of ('yaml', 'urdf', 'sdf', 'mjcf', 'dmd', 'mesh', "
            "'moveit')",
        ),
        (TEXT, {'srdf': 'a.srdf'}, '<text>: srdf is only for a URDF'),
        (TEXT + 'frames: 1', {}, '<text>:3: frames: 1 must be a list'),
        ('<robot/>', {}, '<text>:1: missing attribute `name`'),
        ('<robot name="r"><link name="a"/></robot>', {'srdf': 'a.srdf'}, 'a.srdf: cannot be read'),
        ('<robot name="r">\n</robot>', {'format': 'yaml'}, '<text>'),
        ('a: \ud800\n', {}, '<text>:1: byte 0xed is not UTF-8'),
    ],
)
def test_what_cannot_be_read_says_so(given, options, message):
    with pytest.raises(SceneFileError) as caught:
        read_scene(given, **options)
    assert str(caught.value).startswith(message)


def test_a_file_that_is_not_utf8_is_refused(folder):
    (folder / 'scene.yaml').write_bytes(b'name: \xff\n')
    with pytest.raises(SceneFileError, match=r':1: byte 0xff is not UTF-8'):
        read_scene(folder / 'scene.yaml')


def test_a_file_that_is_too_long_is_not_read_to_its_end(folder, monkeypatch):
    monkeypatch.setattr(scene_file, 'MAX_BYTES', 8)
    with pytest.raises(SceneFileError, match='more than 8 bytes'):
        read_scene(folder / 'scene.yaml')


def test_paths_in_a_text_count_from_the_working_folder(folder, monkeypatch):
    monkeypatch.chdir(folder)
    text = 'geometries:\n- {name: m, shape: {type: mesh, uri: parts/m.obj}}'
    (geometry,) = read_scene(text).geometries
    assert Path(geometry.shape.filename()) == folder / 'parts' / 'm.obj'


def test_a_list_that_is_too_long_is_refused_where_it_gets_so(monkeypatch):
    monkeypatch.setattr(scene_file, 'MOST_ITEMS', 3)
    entries = ''.join(f'- {{name: f{k}}}\n' for k in range(3))
    assert len(scene_file.read_scene(f'frames:\n{entries}').frames) == 3
    # What follows is not looked at.
    with pytest.raises(SceneFileError, match=r'^<text>:5: frames: has more than 3 items$'):
        scene_file.read_scene(f'frames:\n{entries}- {{name: more}}\n- : :')


def test_of_very_many_faults_one_is_told():
    """Each was compared with all others, which took minutes."""
    entries = ''.join(f'- {{nam: f{k}}}\n' for k in range(20_000))
    with pytest.raises(SceneFileError, match=r'^<text>:2: frames\[0\].nam: unknown key'):
        scene_file.read_scene(f'frames:\n{entries}')
