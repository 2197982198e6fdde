"""What every command takes with a scene: an SRDF, and folders of packages."""

import pytest
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.command_line.program import main

URDF = """<robot name="r"><link name="a"><collision><geometry>
<mesh filename="package://parts/m.obj"/></geometry></collision></link></robot>"""


@pytest.fixture
def robot(tmp_path, monkeypatch):
    monkeypatch.delenv('ROS_PACKAGE_PATH', raising=False)
    (tmp_path / 'parts').mkdir()
    (tmp_path / 'parts' / 'm.obj').write_text(TETRAHEDRON)
    (tmp_path / 'r.urdf').write_text(URDF)
    (tmp_path / 'states.csv').write_text('x\n0\n')
    return tmp_path


COMMANDS = [
    ['check', 'r.urdf'],
    ['query', 'r.urdf'],
    ['convert', 'r.urdf', 'out.yaml'],
    ['render', 'r.urdf', '--out', 'out', '--camera', 'none'],
    ['view', 'r.urdf', '--motion', 'none.yaml'],
    ['compile', 'r.urdf'],
]


@pytest.mark.parametrize('command', COMMANDS, ids=lambda command: command[0])
def test_packages_are_found_where_a_command_says(robot, monkeypatch, capsys, command):
    monkeypatch.chdir(robot)
    assert main(command) != 0
    assert "there is no package 'parts'" in capsys.readouterr().err
    for found in (['parts'], ['/nowhere', '.']):
        roots = [word for folder in found for word in ('--package-root', folder)]
        assert main([*command, *roots]) == (2 if command[0] in ('render', 'view') else 0)
        assert 'no package' not in capsys.readouterr().err


@pytest.mark.parametrize('command', [['batch', 'r.urdf', 'states.csv', '--out', 'o.npz']])
def test_a_batch_takes_them_too(robot, monkeypatch, capsys, command):
    monkeypatch.chdir(robot)
    assert main([*command, '--package-root', '.']) == 2
    assert 'no robot with joints' in capsys.readouterr().err


@pytest.mark.parametrize('kind', ['poses', 'points'])
def test_tables_that_are_not_utf_8_are_refused_in_one_line(robot, monkeypatch, capsys, kind):
    monkeypatch.chdir(robot)
    (robot / 'table.csv').write_bytes('x,y,z\n0,0,é\n'.encode('latin-1'))
    command = ['query', 'r.urdf', '--package-root', '.', f'--{kind}', 'table.csv']
    assert main([*command, *(['--what', 'points'] if kind == 'points' else [])]) == 2
    assert 'table.csv:2: byte 0xe9 is not UTF-8' in capsys.readouterr().err
