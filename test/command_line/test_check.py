"""`check`: what is in a scene, and what is wrong with one that is bad."""

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SignedDistanceResults

FILTERED = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}, {name: c, source: s}]
geometries:
- {name: x, source: s, frame: a, shape: {type: sphere, radius: 1}}
- {name: y, source: s, frame: a, shape: {type: sphere, radius: 1}}
- {name: x, source: s, frame: b, shape: {type: sphere, radius: 1}}
- {name: x, source: s, frame: c, shape: {type: sphere, radius: 1}}
filters:
- group: {name: g, members: [a], ignores: [h]}
- group: {name: h, members: [b]}
- clique: {name: k, members: [b, c]}
- exclude_between: [[a/x], [c]]
"""


def test_a_scene_is_listed(capsys):
    assert main(['check', str(ROOT / 'scenes/minimal.yaml')]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith('sources 1, frames 1, geometries 3, filters 0')
    assert '  scene::ball in world at 0.5 0 1' in lines
    assert '  scene::ball/ball: Sphere(radius=0.1), proximity' in lines
    assert lines[-1].startswith('pairs 3: reported 2, anchored 1, on one frame 0,')


PRESSING = """
geometries:
- {name: floor, shape: {type: half_space}, roles: {proximity: {hydroelastic: {
    compliance_type: rigid}}}}
- {name: ball, shape: {type: sphere, radius: 0.1}, roles: {proximity: {hydroelastic: {
    compliance_type: compliant, hydroelastic_modulus: 2e6, resolution_hint: 0.2}}}}
- {name: box, shape: {type: box, size: [1, 1, 1]}, roles: {proximity: {hydroelastic: {
    compliance_type: rigid}}}}
- {name: bystander, shape: {type: box, size: [1, 1, 1]}}
"""


def test_who_has_contact_surfaces_is_told(capsys, tmp_path):
    path = tmp_path / 'pressing.yaml'
    path.write_text(PRESSING)
    assert main(['check', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    start = lines.index('contact surfaces')
    assert lines[start + 1 : start + 5] == [
        '  scene::world/floor: rigid, half space',
        '  scene::world/ball: compliant, 2e+06 Pa, 8 tetrahedra',
        '  scene::world/box: rigid, 24 triangles',
        'filters',
    ]


PLAIN = '\ngeometries:\n- {name: floor, shape: {type: half_space}}\n'


@pytest.mark.parametrize('others', [PRESSING, PLAIN], ids=['pressing', 'plain'])
def test_pairs_of_half_spaces_are_named(capsys, tmp_path, others):
    path = tmp_path / 'planes.yaml'
    moving = '\n'.join(
        f'- {{name: {name}, frame: f, shape: {{type: half_space}}}}' for name in ('belt', 'other')
    )
    path.write_text(f'frames: [{{name: f, pose: {{}}}}]{others}{moving}\n')
    assert main(['check', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    start = lines.index('pairs of half spaces')
    why = (
        'in collision unless they are opposed and apart, without a distance, a depth or a contact'
    )
    assert lines[start + 1 : start + 4] == [
        f'  scene::world/floor and scene::f/belt: {why} surface; filter the pair',
        f'  scene::world/floor and scene::f/other: {why} surface; filter the pair',
        'filters',
    ]
    path.write_text(path.read_text() + 'filters: [{exclude_between: [[world/floor], [f]]}]\n')
    assert main(['check', str(path)]) == 0
    assert 'half spaces' not in capsys.readouterr().out


def test_filtered_pairs_are_listed_with_reasons(capsys, tmp_path):
    path = tmp_path / 'filtered.yaml'
    path.write_text(FILTERED)
    assert main(['check', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert '  group g (s::a) ignores h' in lines
    assert '  clique k: s::b, s::c' in lines
    assert '  ExcludeBetween (s::a/x) and (s::c)' in lines
    assert '  s::a/x and s::b/x: group g' in lines
    assert '  s::b/x and s::c/x: clique k' in lines
    assert '  s::a/x and s::c/x: persistent declaration 0' in lines
    assert not any(line.startswith('  s::a/x and s::a/y') for line in lines)
    assert lines[-1].startswith('pairs 6: reported 1, anchored 0, on one frame 1, ')
    assert main(['check', '--all-pairs', str(path)]) == 0
    assert '  s::a/x and s::a/y: same frame' in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize(
    ('text', 'place', 'word'),
    [
        (FILTERED.replace('radius: 1', 'radius: -1', 1), ':5:', 'radius'),
        (FILTERED.replace('members: [b]', 'members: [z]'), ':11:', "'z'"),
        ('frames: [', ':1:', 'YAML'),
    ],
)
def test_a_bad_scene_is_exit_code_1_with_the_line(capsys, tmp_path, text, place, word):
    path = tmp_path / 'bad.yaml'
    path.write_text(text)
    assert main(['check', str(path)]) == 1
    output, errors = capsys.readouterr()
    assert output == ''
    assert f'bad.yaml{place}' in errors
    assert word in errors
    assert errors.count('\n') == 1


def test_a_frame_without_a_pose_is_listed_as_one_that_waits(capsys, tmp_path):
    path = tmp_path / 'waits.yaml'
    path.write_text('frames: [{name: a, pose: {}}, {name: b, parent: a}]')
    assert main(['check', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert '  scene::a in world at 0 0 0' in lines
    assert '  scene::b in scene::a waits for a pose' in lines


@pytest.mark.processes
def test_python_fcl_agrees_about_a_scene(capsys):
    assert main(['check', '--cross-check', str(ROOT / 'scenes/minimal.yaml')]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith('cross-checked by python-fcl ')
    assert last.endswith(': pairs 2: agreed 2, disagreed 0, refuted 0, silent 0, lost 0')


@pytest.mark.processes
def test_a_disagreement_is_listed_and_is_the_exit_code(capsys, monkeypatch):
    right = SignedDistanceResults.distance.fget
    wrong = property(lambda results: right(results) - 0.01)
    monkeypatch.setattr(SignedDistanceResults, 'distance', wrong)
    assert main(['check', '--cross-check', str(ROOT / 'scenes/minimal.yaml')]) == 1
    lines = capsys.readouterr().out.splitlines()
    told = '  disagreed: scene::world/post and scene::ball/ball: 0.34 m within '
    assert [line for line in lines if line.startswith(told)]


def test_without_fcl_the_extra_is_named(capsys, monkeypatch):
    monkeypatch.setattr('drake_geom_ros.cross_check.asker.find_spec', lambda name: None)
    assert main(['check', '--cross-check', str(ROOT / 'scenes/minimal.yaml')]) == 2
    told = capsys.readouterr().err
    assert 'pip install python-fcl' in told
    assert "extra 'cross_check'" in told


def test_a_mesh_is_listed_as_queries_see_it(capsys, tmp_path):
    points = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n'
    (tmp_path / 'a.obj').write_text(f'{points}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n')
    path = tmp_path / 'scene.yaml'
    path.write_text("""
geometries:
- {name: hull, shape: {type: mesh, uri: a.obj}}
- {name: solid, shape: {type: mesh, uri: a.obj}, roles: {proximity: {mesh: {solid: true}}}}
- {name: convex, shape: {type: convex, uri: a.obj}}
""")
    assert main(['check', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert '  scene::world/hull: mesh a.obj (as its hull, 4 vertices), proximity' in lines
    assert '  scene::world/solid: mesh a.obj (as a solid, 4 triangles), proximity' in lines
    assert '  scene::world/convex: convex a.obj (4 vertices), proximity' in lines


URDF = """<robot name="r" version="1.1">
<link name="a"><glue/></link>
<link name="b"><glue/><collision><origin xyz="0.1 0 0" quat_xyzw="0 0 0.7071 0.7071"/>
<geometry><box size="1 0.1 0.1"/></geometry></collision></link>
{joints}</robot>"""
JOINT = '<joint name="{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>\n'


def test_what_is_not_understood_in_a_urdf_is_told_once_on_standard_error(capsys, tmp_path):
    path = tmp_path / 'r.urdf'
    path.write_text(URDF.format(joints=JOINT.format('j', 'a', 'b')))
    assert main(['check', str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == (
        f'warning: {path}:2: link[a].glue: <glue> in <link> is not understood. It is left out '
        '(and 1 more like it)\n'
    )
    assert 'glue' not in out


@pytest.mark.parametrize(
    ('joints', 'reason'),
    [
        (('jab', 'jab'), "joint 'j' is listed twice"),
        (('jab', 'kba'), 'joints form a ring'),
        (('jab', 'kbb'), "link 'b' has two parents"),
    ],
)
def test_what_is_no_tree_is_refused_by_check(capsys, tmp_path, joints, reason):
    path = tmp_path / 'r.urdf'
    path.write_text(URDF.format(joints=''.join(JOINT.format(*joint) for joint in joints)))
    assert main(['check', str(path)]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f'drake_geom_ros: {path}:6: joint[')
    assert reason in error
