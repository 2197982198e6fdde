from pathlib import Path

import pytest

from drake_geom_ros.geometry import Mesh, Role, Sphere
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    DeactivationDescription,
    DeclarationDescription,
    GroupDescription,
    Member,
    Operation,
    Statement,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.scene_file import read_scene
from drake_geom_ros.scene_files.yaml_scene import parse_scene
from drake_geom_ros.scene_files.yaml_text import read_yaml

URDF = """<robot name="arm">
<link name="a"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<link name="b"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
</robot>"""
SRDF = '<robot name="arm"><disable_collisions link1="a" link2="b"/></robot>'


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    (tmp_path / 'arm.srdf').write_text(SRDF)
    (tmp_path / 'm.obj').write_text('v 0 0 0')
    return tmp_path


def parse(text, folder=Path('/')):
    return parse_scene(read_yaml(text, 'a.yaml'), folder, ResourceResolver())


def test_defaults():
    scene = parse(
        'frames:\n- {name: f}\ngeometries:\n- {name: g, shape: {type: sphere, radius: 1}}'
    )
    (frame,), (geometry,) = scene.frames, scene.geometries
    assert (frame.source, frame.parent, frame.group, frame.X_PF) == ('scene', 'world', 0, None)
    assert (geometry.source, geometry.frame) == ('scene', 'world')
    assert geometry.X_FG.IsExactlyIdentity()
    assert geometry.shape == Sphere(1)
    assert list(geometry.roles) == [Role.kProximity]
    assert scene.sources == ('scene',)


def test_the_name_of_the_scene_is_the_source_of_what_names_none():
    scene = parse('name: room\nframes:\n- {name: f}\n- {name: g, source: s}')
    assert [frame.source for frame in scene.frames] == ['room', 's']


def test_sources_come_as_listed_then_as_named(folder):
    scene = parse(
        """
sources: [z, unused]
frames:
- {name: f, source: y}
geometries:
- {name: g, source: x, shape: {type: half_space}}
robots:
- {name: arm, urdf: arm.urdf}
""",
        folder,
    )
    assert scene.sources == ('z', 'unused', 'arm', 'y', 'x')


def test_names_are_trimmed():
    scene = parse(
        """
frames:
- {name: ' f ', source: "\\ts", parent: ' world'}
filters:
- clique: {name: ' c ', members: [f]}
- group: {name: ' g ', members: [f], ignores: [' h ']}
"""
    )
    (frame,) = scene.frames
    assert (frame.name, frame.source, frame.parent) == ('f', 's', 'world')
    clique, group = scene.filters
    assert (clique.name, group.name, group.ignores) == ('c', 'g', ('h',))


def test_a_robot_becomes_a_source_with_frames_geometries_and_filters(folder):
    text = 'robots:\n- {name: left, urdf: arm.urdf, srdf: arm.srdf, pose: {position: [1, 0, 0]}}'
    scene = parse(text, folder)
    (robot,) = scene.robots
    assert (robot.name, robot.urdf) == ('left', folder / 'arm.urdf')
    assert robot.X_WB.translation().tolist() == [1, 0, 0]
    assert [(frame.source, frame.name) for frame in scene.frames] == [('left', 'a'), ('left', 'b')]
    assert len(scene.geometries) == 2
    clique, declaration = scene.filters
    assert isinstance(clique, CliqueDescription)
    assert isinstance(declaration, DeclarationDescription)


def test_two_robots_of_one_urdf_share_nothing(folder):
    text = 'robots:\n- {name: left, urdf: arm.urdf}\n- {name: right, urdf: arm.urdf}'
    scene = parse(text, folder)
    assert scene.sources == ('left', 'right')
    assert [clique.name for clique in scene.filters] == ['left: a - b', 'right: a - b']


@pytest.mark.parametrize(
    ('options', 'names'),
    [
        ('', ['r: a - b']),
        (', adjacent_links: filtered', ['r: a - b']),
        (', adjacent_links: kept', []),
        (', self_collisions: filtered', ['r: a - b', 'r: all links']),
        (', self_collisions: kept', ['r: a - b']),
    ],
)
def test_options_of_a_robot(folder, options, names):
    scene = parse(f'robots:\n- {{name: r, urdf: arm.urdf{options}}}', folder)
    assert [clique.name for clique in scene.filters] == names


def test_a_loaded_robot_brings_nothing_of_its_own(folder):
    scene = parse('robots:\n- {name: r, urdf: arm.urdf, loaded: true}', folder)
    assert len(scene.robots) == 1
    assert (scene.frames, scene.geometries, scene.filters) == ((), (), ())
    assert scene.sources == ('r',)


def test_filters_come_in_their_order():
    scene = parse(
        """
frames: [{name: f}, {name: g}]
geometries:
- {name: a, frame: f, shape: {type: half_space}}
filters:
- deactivate: [f/a]
- exclude_within: [f, g]
- allow_between: [[f], [g, world]]
- declaration:
  - allow_within: [f/a]
  - exclude_between: [[], [g]]
- group: {name: n, members: [f], ignores: [m, universal]}
- clique: {name: c, members: [g]}
"""
    )
    f, g, a = Member('scene', 'f'), Member('scene', 'g'), Member('scene', 'f', 'a')
    assert scene.filters == (
        DeactivationDescription((a,)),
        DeclarationDescription((Statement(Operation.EXCLUDE_WITHIN, (f, g)),)),
        DeclarationDescription(
            (Statement(Operation.ALLOW_BETWEEN, (f,), (g, Member('', 'world'))),)
        ),
        DeclarationDescription(
            (
                Statement(Operation.ALLOW_WITHIN, (a,)),
                Statement(Operation.EXCLUDE_BETWEEN, (), (g,)),
            )
        ),
        GroupDescription('n', (f,), ('m', 'universal')),
        CliqueDescription('c', (g,)),
    )


def test_a_mesh_counts_from_the_folder(folder):
    text = 'geometries:\n- {name: m, shape: {type: mesh, uri: m.obj, scale: [1, 2, 3]}}'
    (geometry,) = parse(text, folder).geometries
    assert geometry.shape == Mesh(str(folder / 'm.obj'), [1, 2, 3])


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('frames:\n- name: f\n  pose: {quaternion: [0, 0, 0, 2]}', 'a.yaml:3: frames[0].pose: '),
        ('robots:\n- name: r\n  urdf: arm.urdf\n  pose: {quaternion: [0, 0, 0, 2]}',
         'a.yaml:4: robots[0].pose: '),
        ('geometries:\n- name: g\n  shape:\n    type: mesh\n    uri: n.obj',
         "a.yaml:3: geometries[0].shape: 'n.obj': there is no file"),
        ('geometries:\n- name: g\n  shape: {type: mesh, uri: m.obj, scale: [1, 0, 1]}',
         'a.yaml:3: geometries[0].shape: Mesh: |scale| must be finite'),
        ('geometries:\n- name: g\n  shape: {type: half_space}\n  pose: {rotation: [[1, 0, 0], '
         '[1, 0, 0], [1, 0, 0]]}', 'a.yaml:4: geometries[0].pose: '),
        ('geometries:\n- name: g\n  shape: {type: half_space}\n'
         '  roles: {proximity: {g: {a: {array: [[1], [1, 2]]}}}}',
         'a.yaml:4: geometries[0].roles: '),
        ('robots:\n- {name: r,\n   urdf: none.urdf}',
         "a.yaml:3: robots[0].urdf: 'none.urdf': there is no file"),
        ('robots:\n- {name: r, urdf: arm.urdf,\n   srdf: none.srdf}',
         "a.yaml:3: robots[0].srdf: 'none.srdf': there is no file"),
        ('robots:\n- {name: r,\n   urdf: "package://nowhere/a.urdf"}',
         "a.yaml:3: robots[0].urdf: 'package://nowhere/a.urdf': there is no package"),
        ('filters:\n- exclude_within:\n  - world\n  - nose',
         "a.yaml:4: filters[0].exclude_within[1]: 'nose' is neither a frame"),
        ('filters:\n- declaration:\n  - allow_between: [[], [nose]]',
         "a.yaml:3: filters[0].declaration[0].allow_between[1][0]: 'nose' is neither a frame"),
        ('filters:\n- clique:\n    name: c\n    members: [nose]',
         "a.yaml:4: filters[0].clique.members[0]: 'nose' is neither a frame"),
        ('filters:\n- deactivate: [world, nose]',
         "a.yaml:2: filters[0].deactivate[1]: 'nose' is neither a frame"),
        ('frames: 1', 'a.yaml:1: frames: 1 must be a list'),
    ],
)  # fmt: skip
def test_each_fault_names_its_line(folder, text, message):
    with pytest.raises(SceneFileError) as caught:
        parse(text, folder)
    assert str(caught.value).startswith(message)


def test_a_fault_in_a_urdf_names_the_urdf(folder):
    (folder / 'arm.urdf').write_text(URDF.replace('radius="1"', 'radius="-1"'))
    with pytest.raises(SceneFileError) as caught:
        parse('robots:\n- {name: r, urdf: arm.urdf}', folder)
    assert caught.value.file == str(folder / 'arm.urdf')
    assert caught.value.line == 2


FIXED_HAND = """<robot name="arm">
<link name="base"/><link name="mount"/><link name="hand"><collision><geometry><sphere radius="1"/>
</geometry></collision><glue/></link>
<joint name="j" type="fixed"><parent link="base"/><child link="mount"/><origin xyz="0 1 0"/>
</joint>
<joint name="k" type="continuous"><parent link="mount"/><child link="hand"/></joint>
</robot>"""


def test_the_pose_of_a_robot_is_that_of_its_root_and_of_what_is_fixed_to_it(folder):
    (folder / 'fixed.urdf').write_text(FIXED_HAND)
    text = 'robots:\n- {name: left, urdf: fixed.urdf, pose: {position: [0, 0, 2]}}'
    poses = {frame.name: frame.X_PF for frame in parse(text, folder).frames}
    assert poses['hand'] is None
    assert poses['base'].translation().tolist() == [0, 0, 2]
    assert poses['mount'].translation().tolist() == [0, 1, 2]


def test_without_the_key_no_link_has_a_pose(folder):
    (folder / 'fixed.urdf').write_text(FIXED_HAND)
    scene = parse('robots:\n- {name: left, urdf: fixed.urdf}', folder)
    assert [frame.X_PF for frame in scene.frames] == [None] * 3


def test_a_pose_needs_one_root_link(folder):
    (folder / 'two.urdf').write_text('<robot name="r"><link name="a"/><link name="b"/></robot>')
    with pytest.raises(SceneFileError, match=r"a.yaml:2: robots\[0\].pose: .* 'a', 'b' have no"):
        parse('robots:\n- {name: left, urdf: two.urdf, pose: {}}', folder)


def test_what_a_urdf_says_beyond_what_is_understood_is_a_warning(folder):
    (folder / 'fixed.urdf').write_text(FIXED_HAND)
    (warning,) = parse('robots:\n- {name: left, urdf: fixed.urdf}', folder).warnings
    assert warning.startswith(f'{folder}/fixed.urdf:3: link[hand].glue: <glue> in <link>')


@pytest.mark.parametrize(
    'key', ['adjacent_links: kept', 'self_collisions: filtered', 'solid_meshes: []']
)
def test_a_loaded_robot_refuses_what_would_have_no_effect(folder, key):
    with pytest.raises(
        SceneFileError, match=r'robots\[0\]\.\w+: has no effect with `loaded: true`'
    ):
        parse(f'robots:\n- {{name: r, urdf: arm.urdf, loaded: true, {key}}}', folder)


def test_a_scene_file_names_folders_of_packages(tmp_path, monkeypatch):
    monkeypatch.delenv('ROS_PACKAGE_PATH', raising=False)
    for place in ('robots', 'given'):
        (tmp_path / place / 'arms').mkdir(parents=True)
        (tmp_path / place / 'arms/a.urdf').write_text(
            f'<robot name="{place}"><link name="{place}"/></robot>'
        )
    path = tmp_path / 'cells' / 'cell.yaml'
    path.parent.mkdir()
    path.write_text('package_roots: [../robots]\nrobots: [{name: r, urdf: package://arms/a.urdf}]')
    assert read_scene(path).frames[0].name == 'robots'
    assert read_scene(path, package_roots=tmp_path / 'given').frames[0].name == 'given'
    with pytest.raises(SceneFileError, match='outside the folders'):
        read_scene(path, allowed_roots=path.parent)


@pytest.mark.parametrize(
    ('padding', 'found'),
    [('0.01', [0.01, 0.01]), ("{'*': 0.01, b: 0.02}", [0.01, 0.02]), ('{a/*: 0.5}', [0.5, 0.0])],
)
def test_a_robot_is_padded_all_over_or_by_link(folder, padding, found):
    scene = parse(f'robots: [{{name: r, urdf: arm.urdf, padding: {padding}}}]', folder)
    properties = [g.roles[Role.kProximity] for g in scene.geometries]
    assert [p.GetPropertyOrDefault('proximity', 'padding', 0.0) for p in properties] == found


@pytest.mark.parametrize('padding', ['-0.1', '{a: -1}', '{a: x}', 'no'])
def test_a_padding_that_is_no_length_is_refused(folder, padding):
    with pytest.raises(SceneFileError, match='padding'):
        parse(f'robots: [{{name: r, urdf: arm.urdf, padding: {padding}}}]', folder)
