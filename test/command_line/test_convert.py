"""`convert`: a URDF becomes the scene that it is; pose files become each other."""

import numpy as np
import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line.pose_file import read_poses
from drake_geom_ros.command_line.program import main
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.sensed_maps import read_map
from drake_geom_ros.sensed_maps.pcd_file import pcd_file

URDF = """<robot name="cart">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="wheel"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
  <link name="arm"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="axle" type="continuous"><parent link="base"/><child link="wheel"/></joint>
  <joint name="pin" type="continuous"><parent link="base"/><child link="arm"/></joint>
</robot>
"""
SRDF = '<robot name="cart"><disable_collisions link1="arm" link2="wheel"/></robot>'


def listed(capsys, path, *more):
    assert main(['check', str(path), *more]) == 0
    return capsys.readouterr().out.splitlines()[-1]


def test_a_urdf_with_its_srdf_becomes_a_scene_file(capsys, tmp_path):
    urdf, srdf, scene = (tmp_path / name for name in ('cart.urdf', 'cart.srdf', 'cart.yaml'))
    urdf.write_text(URDF)
    srdf.write_text(SRDF)
    assert main(['convert', str(urdf), str(scene), '--srdf', str(srdf)]) == 0
    before, after = read_scene(urdf, srdf=srdf), read_scene(scene)
    assert [f.name for f in after.frames] == [f.name for f in before.frames]
    assert [g.shape for g in after.geometries] == [g.shape for g in before.geometries]
    counted = listed(capsys, scene)
    assert counted == listed(capsys, urdf, '--srdf', str(srdf))
    assert counted.startswith('pairs 3: reported 0, ')


SPHERE = (
    '<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>'
)
MODELS = {
    'cart.sdf': '<sdf version="1.9"><model name="cart"><link name="base">'
    + SPHERE
    + '</link><link name="wheel">'
    + SPHERE
    + '</link><joint name="j" type="revolute"><parent>base</parent><child>wheel</child>'
    '<pose>0 0 0.1 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>',
    'cart.xml': '<mujoco model="cart"><worldbody><body name="base"><freejoint/><geom size="0.1"/>'
    '<body name="wheel"><joint pos="0 0 0.1"/><geom size="0.1"/></body></body></worldbody>'
    '</mujoco>',
    'cell.dmd.yaml': 'directives:\n- add_model: {name: cart, file: cart.urdf}\n'
    '- add_weld: {parent: world, child: cart::base}\n',
}


@pytest.mark.parametrize('name', MODELS)
def test_a_model_of_any_format_becomes_a_scene_file(capsys, tmp_path, name):
    if name.endswith('.xml'):
        pytest.importorskip('mujoco', exc_type=ImportError)
    (tmp_path / 'cart.urdf').write_text(URDF)
    model, scene = tmp_path / name, tmp_path / 'scene.yaml'
    model.write_text(MODELS[name])
    assert main(['convert', str(model), str(scene)]) == 0
    before, after = read_scene(model), read_scene(scene)
    assert [f.name for f in after.frames] == [f.name for f in before.frames]
    assert [r.tree for r in after.robots] == [r.tree for r in before.robots]
    assert listed(capsys, scene) == listed(capsys, model)


def test_poses_go_to_json_and_back(tmp_path):
    first, middle, last = (tmp_path / name for name in ('a.csv', 'b.json', 'c.csv'))
    first.write_text('time,frame,x,y,z,qx,qy,qz,qw\n0.0,f,1.0,2.0,3.0,0.0,0.0,0.0,1.0\n')
    assert main(['convert', str(first), str(middle)]) == 0
    assert main(['convert', str(middle), str(last)]) == 0
    assert last.read_text() == first.read_text()
    assert read_poses(middle)[0].time == 0.0


@pytest.mark.parametrize('name', ['bad.urdf', 'bad.csv'])
def test_a_bad_input_writes_nothing(capsys, tmp_path, name):
    (tmp_path / name).write_text('<robot')
    target = tmp_path / ('out.yaml' if name.endswith('urdf') else 'out.json')
    assert main(['convert', str(tmp_path / name), str(target)]) == 2
    assert name in capsys.readouterr().err
    assert not target.exists()


def test_the_scene_that_ships_survives(capsys, tmp_path):
    target = tmp_path / 'again.yaml'
    scene = ROOT / 'scenes/minimal.yaml'
    assert main(['convert', str(scene), str(target)]) == 0
    assert listed(capsys, target) == listed(capsys, scene)


@pytest.mark.parametrize('name', ['robot.xml', 'R.URDF', 'robot_description'])
def test_a_urdf_is_converted_whatever_it_is_called(tmp_path, name):
    (tmp_path / name).write_text(
        '<robot name="r"><link name="a"><collision><geometry><sphere radius="1"/></geometry>'
        '</collision></link></robot>'
    )
    assert main(['convert', str(tmp_path / name), str(tmp_path / 'r.yaml')]) == 0
    assert 'radius: 1' in (tmp_path / 'r.yaml').read_text()


CORNERS = '0.01 0.02 0.03\n0.04 0.01 0.02\n1.01 -2.02 3.03\n'


def test_points_become_cells_and_cells_points(tmp_path):
    (tmp_path / 'a.xyz').write_text(CORNERS)
    path = str(tmp_path / 'a.xyz')
    assert main(['convert', path, str(tmp_path / 'a.bt'), '--resolution', '0.05']) == 0
    for suffix in ('.pcd', '.ply', '.npy', '.xyz'):
        target = tmp_path / f'b{suffix}'
        assert main(['convert', str(tmp_path / 'a.bt'), str(target)]) == 0
        centres = read_map(target).points
        expected = [[0.025, 0.025, 0.025], [1.025, -2.025, 3.025]]
        assert centres == pytest.approx(np.array(expected), abs=1e-12)
    coarse = tmp_path / 'c.bt'
    assert main(['convert', str(tmp_path / 'a.bt'), str(coarse), '--resolution', '10']) == 0
    assert read_map(coarse).cells.keys().tolist() == [[0, -1, 0], [0, 0, 0]]
    assert main(['convert', path, str(tmp_path / 'thin.xyz'), '--resolution', '0.05']) == 0
    assert len(read_map(tmp_path / 'thin.xyz').points) == 2


@pytest.mark.parametrize(
    ('target', 'more', 'reason'),
    [
        ('b.bt', [], 'was not given'),
        ('b.bt', ['--resolution', '0'], 'must lie in'),
        ('b.ot', ['--resolution', '1'], 'not written'),
        ('b.yaml', [], 'not written'),
        ('a.xyz', [], 'written over'),
    ],
)
def test_a_map_that_cannot_be_converted_is_refused(capsys, tmp_path, target, more, reason):
    (tmp_path / 'a.xyz').write_text(CORNERS)
    assert main(['convert', str(tmp_path / 'a.xyz'), str(tmp_path / target), *more]) == 2
    assert reason in capsys.readouterr().err
    assert (tmp_path / 'a.xyz').read_text() == CORNERS
    assert [each.name for each in tmp_path.iterdir()] == ['a.xyz']


EMPTY = {
    'free.ot': (
        b'# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n\x00\x00\x80\xbf\x00',
        'no occupied cell',
    ),
    'free.bt': (
        b'# Octomap OcTree binary file\nid OcTree\nsize 0\nres 0.1\ndata\n',
        'no occupied cell',
    ),
    'all.xyz': (b'nan nan nan\ninf 0 0\n', '2 points, none of which is finite'),
    'none.pcd': (pcd_file(np.zeros((0, 3))), '0 points'),
}


@pytest.mark.parametrize('target', ['b.bt', 'b.pcd', 'b.ply', 'b.xyz', 'b.npy'])
@pytest.mark.parametrize('name', EMPTY)
def test_a_map_that_holds_nothing_becomes_no_file(capsys, tmp_path, name, target):
    content, reason = EMPTY[name]
    (tmp_path / name).write_bytes(content)
    asked = ['convert', str(tmp_path / name), str(tmp_path / target), '--resolution', '0.1']
    assert main(asked) == 2
    told = capsys.readouterr().err
    assert name in told
    assert reason in told
    assert [each.name for each in tmp_path.iterdir()] == [name]


def test_points_that_are_not_finite_are_told_of(capsys, tmp_path):
    np.save(tmp_path / 'a.npy', [[np.nan, 0.0, 0.0], [1.0, 2.0, 3.0]])
    assert main(['convert', str(tmp_path / 'a.npy'), str(tmp_path / 'a.xyz')]) == 0
    assert 'left out 1 point that is not finite' in capsys.readouterr().out
    assert (tmp_path / 'a.xyz').read_text() == '1.0 2.0 3.0\n'
