"""Whatever way a file is asked for, and however it is named: none outside the roots is opened.

An audit hook sees every file that Python opens, so that it is not only refused in words.
"""

import os
import sys
from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import TWO_BALLS, live_scene
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.services import files, shapes

CONVEX, MESH = 7, 8
LINK = '<robot name="r"><link name="l">{}</link></robot>'
OF_MESH = '<collision><geometry><mesh filename="{}"/></geometry></collision>'
POSE = Plain(position=Plain(x=0.0, y=0.0, z=0.0), orientation=Plain(x=0.0, y=0.0, z=0.0, w=1.0))
OPENED = []
WATCHING = []


def watch(event, arguments):
    """Note what is opened while a test watches; a hook cannot be taken away again."""
    if WATCHING and event == 'open' and isinstance(arguments[0], str | os.PathLike):
        OPENED.append(os.path.realpath(arguments[0]))


sys.addaudithook(watch)


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Return a folder whose files may be opened, and one beside it, with the same files."""
    inside, outside = tmp_path / 'inside', tmp_path / 'inside_not'
    for folder in inside, outside:
        folder.mkdir()
        (folder / 'mesh.obj').write_text(TETRAHEDRON)
        (folder / 'scene.yaml').write_text('sources: [other]\n')
        (folder / 'robot.urdf').write_text(LINK.format(''))
        (folder / 'robot.srdf').write_text('<robot name="r"/>')
    (tmp_path / 'share').mkdir()
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    (tmp_path / 'share/inside').mkdir()
    monkeypatch.chdir(inside)
    return inside, outside


@pytest.fixture
def live(folders):
    live = live_scene(TWO_BALLS)
    live.files = FileAccess([str(folders[0])])
    return live


def shape(uri, kind=CONVEX):
    return Plain(type=kind, dimensions=[], vertices=[], triangles=[], mesh_uri=uri)


def load(**fields):
    given = {
        'path': '',
        'text': '',
        'format': '',
        'srdf': '',
        'replace': False,
        'replaced_sources': [],
        **fields,
    }
    return files.load_scene, Plain(**given)


def register(uri, kind):
    roles = {'roles': [Plain(role=1, properties=[])], 'parent_geometry': ''}
    place = {'source': 's', 'frame': 'a', 'name': 'new', 'pose': POSE}
    return shapes.register_geometry, Plain(**place, **roles, shape=shape(uri, kind))


def scene_with(entry):
    return load(text=f'sources: [t]\n{entry}\n', format='yaml')


# By the file that is asked for: handler and request.
WAYS = {
    'register a hull': ('mesh.obj', lambda uri: register(uri, CONVEX)),
    'register a mesh': ('mesh.obj', lambda uri: register(uri, MESH)),
    'change a shape': (
        'mesh.obj',
        lambda uri: (shapes.change_shape, Plain(geometry='b/ball', shape=shape(uri))),
    ),
    'load a scene': ('scene.yaml', lambda uri: load(path=uri)),
    'load a robot': ('robot.urdf', lambda uri: load(path=uri)),
    'load an SRDF': (
        'robot.srdf',
        lambda uri: load(text=LINK.format(''), format='urdf', srdf=uri),
    ),
    'mesh of a scene': (
        'mesh.obj',
        lambda uri: scene_with(
            f'geometries: [{{name: m, source: t, shape: {{type: convex, uri: "{uri}"}}}}]'
        ),
    ),
    'robot of a scene': (
        'robot.urdf',
        lambda uri: scene_with(f'robots: [{{name: r, urdf: "{uri}"}}]'),
    ),
    'mesh of a robot': (
        'mesh.obj',
        lambda uri: load(text=LINK.format(OF_MESH.format(uri)), format='urdf'),
    ),
    'robot description': (
        'mesh.obj',
        lambda uri: (
            lambda live, request, response: RobotInput(live).take(request),
            LINK.format(OF_MESH.format(uri)),
        ),
    ),
}
# How the file of that name in the folder that is not allowed can be named.
NAMES = {
    'path': '{outside}/{name}',
    'file': 'file://{outside}/{name}',
    'dots': '{inside}/../inside_not/{name}',
    'dots in a URI': 'file://{inside}/../inside_not/{name}',
    'escaped dots': 'file://{inside}/%2e%2e/inside_not/{name}',
    'package': 'package://inside/../../inside_not/{name}',
    'package of dots': 'package://../inside_not/{name}',
}


def answer(live, handler, request):
    """Return what a handler says, and what was opened meanwhile."""
    OPENED.clear()
    WATCHING.append(True)
    try:
        guard = Guard(logger=None, count=None)
        response = Plain(success=False, message='', text='')
        return guard.answer(handler, live, request, response), list(OPENED)
    finally:
        WATCHING.clear()


@pytest.mark.parametrize('way', WAYS)
def test_inside_it_is_opened(live, folders, way):
    name, ask = WAYS[way]
    response, opened = answer(live, *ask(f'{folders[0]}/{name}'))
    assert response.success, response.message
    assert str(folders[0] / name) in opened


@pytest.mark.parametrize('named', NAMES)
@pytest.mark.parametrize('way', WAYS)
def test_outside_it_is_refused_and_not_opened(live, folders, way, named):
    inside, outside = folders
    name, ask = WAYS[way]
    uri = NAMES[named].format(inside=inside, outside=outside, name=name)
    response, opened = answer(live, *ask(uri))
    assert not response.success
    assert 'outside the folders' in response.message or 'inside its package' in response.message
    assert not [path for path in opened if str(outside) in path]


def test_a_link_is_followed_to_read_and_not_to_write(live, folders):
    """As colcon installs by links, the files of a package may lie elsewhere."""
    inside, outside = folders
    (inside / 'link.obj').symlink_to(outside / 'mesh.obj')
    (inside / 'link.yaml').symlink_to(outside / 'scene.yaml')
    (inside / 'folder').symlink_to(outside)
    assert answer(live, *register(f'{inside}/link.obj', CONVEX))[0].success
    for name in 'link.yaml', 'folder/scene.yaml', 'folder/new.yaml', '../inside_not/new.yaml':
        response, _ = answer(live, files.save_scene, Plain(path=f'{inside}/{name}'))
        assert not response.success
        assert 'mesh_roots' in response.message
    assert (outside / 'scene.yaml').read_text() == 'sources: [other]\n'
    assert not (outside / 'new.yaml').exists()


@pytest.mark.parametrize('text', [LINK.format('&x;'), '<robot name="r" xmlns:x="x">&x;</robot>'])
def test_an_entity_opens_no_file(live, folders, text):
    """What lxml opens no hook sees: it must not be asked to."""
    _, outside = folders
    (outside / 'secret').write_text('<link name="secret"/>')
    document = f'<!DOCTYPE robot [<!ENTITY x SYSTEM "file://{outside}/secret">]>{text}'
    response, _ = answer(live, *load(text=document, format='urdf'))
    assert not response.success
    assert 'DOCTYPE' in response.message


def test_where_nothing_may_be_written_a_scene_is_told_and_not_saved(live, folders):
    inside, _ = folders
    live.files = FileAccess([str(inside)], writes=False)
    target = inside / 'saved.yaml'
    response, _ = answer(live, files.save_scene, Plain(path=str(target)))
    assert not response.success
    assert 'allow_writes' in response.message
    assert not target.exists()
    response, _ = answer(live, files.save_scene, Plain(path=''))
    assert response.success
    assert 'ball' in response.text
    assert answer(live, *load(path=f'{inside}/scene.yaml'))[0].success
