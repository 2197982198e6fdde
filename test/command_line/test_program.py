"""The program as it is started: exit codes, one line for an error, no ROS."""

import re
import subprocess
import sys
from io import BytesIO
from types import SimpleNamespace

import pytest
from conventions.source_tree import ROOT

import drake_geom_ros
from drake_geom_ros import programs
from drake_geom_ros.command_line import query
from drake_geom_ros.command_line.program import COMMANDS, main

SCENE = str(ROOT / 'scenes/minimal.yaml')
ARMS = str(ROOT / 'scenes/two_pandas.yaml')


def start(*arguments):
    return subprocess.run(
        [sys.executable, '-m', 'drake_geom_ros', *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=800,
    )


@pytest.mark.processes
def test_it_runs_as_a_module():
    done = start('query', 'scenes/minimal.yaml', '--max-distance', '0.5')
    assert done.returncode == 0, done.stderr
    header, row = done.stdout.splitlines()
    assert header.startswith('geometry_a,geometry_b,distance,')
    assert row.startswith('scene::world/post,scene::ball/ball,0.35,')


@pytest.mark.processes
def test_a_first_answer_by_kernels_that_are_there_imports_no_compiler_and_no_scipy():
    """They take 0.3 and 0.2 s, of 0.8."""
    scene = ROOT / 'scenes/two_pandas.yaml'
    code = (
        'import sys\n'
        'from drake_geom_ros.command_line.program import main\n'
        f'main(["query", {str(scene)!r}, "--what", "least"])\n'
        'print(sorted({"scipy.linalg", "numba.np.arraymath"} & sys.modules.keys()))'
    )
    start('query', scene, '--what', 'least')  # now they are
    done = subprocess.run([sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == '[]', done.stderr


@pytest.mark.processes
def test_what_a_scene_needs_is_compiled_beforehand():
    done = start('compile', 'scenes/minimal.yaml')
    assert done.returncode == 0, done.stderr
    assert 'kernels are ready, in ' in done.stdout.splitlines()[-1]
    again = start('compile', 'scenes/minimal.yaml')
    assert len(again.stdout.splitlines()) == 1


@pytest.mark.processes
@pytest.mark.parametrize(
    'arguments', [f'check {SCENE}', 'query --help', 'node --help', 'status --help', 'demo --help']
)
def test_a_reader_that_leaves_early_is_no_error(arguments):
    if not arguments.startswith(('check', 'query')):
        pytest.importorskip('rclpy')
    script = f'{sys.executable} -m drake_geom_ros {arguments} | true; echo "${{PIPESTATUS[0]}}"'
    done = subprocess.run(
        ['bash', '-c', script], cwd=ROOT, capture_output=True, text=True, timeout=800
    )
    assert done.stdout.strip() in ('0', '141')
    assert done.stderr == ''


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['query', '/nowhere.yaml'], ['/nowhere.yaml', 'cannot be read']),
        (['query', SCENE, '--poses', 'poses.txt'], ['poses.txt', '.csv', '.json']),
        (['query', SCENE, '--poses', '/nowhere.csv'], ['/nowhere.csv']),
        (['query', SCENE, '--what', 'points'], ['--points']),
        (['query', SCENE, '--count', '2'], ['--count 2 goes with --what nearest']),
        (
            ['batch', SCENE, 'no.npy', '--out', 'x.npz'],
            ['no.npy: cannot be read: No such'],
        ),
        (['suggest-filters', SCENE], ['there is no robot']),
        (['query', SCENE, '--points', 'p.csv'], ['--what points']),
        (['query', SCENE, '--what', 'points', '--points', '/nowhere.csv'], ['/nowhere.csv']),
        (['query', SCENE, '--out', '/nowhere/out.csv'], ['/nowhere/out.csv: there is no folder']),
        (['check', '/nowhere.yaml'], ['/nowhere.yaml: no such file']),
        (['check', SCENE, '--joints', 'a=1'], ['no robot with joints']),
        (['convert', SCENE, 'out.txt'], ['out.txt', '.yaml']),
        (['convert', SCENE, '/nowhere/out.yaml'], ['/nowhere/out.yaml']),
    ],
)
def test_what_cannot_be_is_said_in_one_line(capsys, arguments, words):
    assert main(arguments) == 2
    output, errors = capsys.readouterr()
    assert output == ''
    assert errors.count('\n') == 1
    for word in words:
        assert word in errors


def test_an_interrupt_is_no_traceback(capsys, monkeypatch):
    def interrupted(options):
        raise KeyboardInterrupt

    monkeypatch.setattr(query, 'run', interrupted)
    assert main(['query', SCENE]) == 130
    assert capsys.readouterr().err == 'drake_geom_ros: interrupted\n'


@pytest.mark.parametrize(
    'arguments',
    [
        [],
        ['dance'],
        ['query'],
        ['query', SCENE, '--what', 'weather'],
        ['query', SCENE, '--max-distance', '-1'],
        ['query', SCENE, '--max-distance', 'nan'],
        ['query', SCENE, '--max-distance', 'far'],
        ['query', SCENE, '--max-distance', '0.5m'],
        ['batch', SCENE, 'x.npy', '--out', 'x.npz', '--max-distance', '-0.01'],
        ['query', SCENE, '--accuracy', 'superb'],
    ],
)
def test_wrong_usage_is_exit_code_2(capsys, arguments):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert 'usage:' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['check-motion', ARMS, '--trajectory', '/'], '/: cannot be read: Is a directory'),
        (
            ['check-motion', ARMS, '--motion', '/no'],
            '/no: cannot be read: No such file or directory',
        ),
    ],
)
def test_what_cannot_be_read_is_named_once(capsys, arguments, words):
    assert main(arguments) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f'drake_geom_ros: {words}'


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['qery'], "there is no command 'qery'; nearest: 'query'"),
        (['query', ''], 'argument: an empty text; was a variable of the shell not set?'),
        (['query', SCENE, '--poses', ''], '--poses: an empty text'),
        (['query', SCENE, '--poses='], '--poses: an empty text'),
        (['--vresion'], "there is no option --vresion; nearest: '--version'"),
        (['query', SCENE, '--max-distanse', '1'], "--max-distanse; nearest: '--max-distance'"),
        (['query', SCENE, '--max-distance', '0.5m'], "'0.5m' has a unit; write a number alone"),
        (['query', SCENE, '--max-distance', 'far'], "'far' is no number"),
        (['query', SCENE, '--max-distance', '-1'], "'-1' must be a distance >= 0 [m]"),
        (['suggest-filters', SCENE, '--states', '0'], "'0' must be a whole number > 0"),
    ],
)
def test_wrong_usage_ends_with_what_was_meant(capsys, arguments, words):
    with pytest.raises(SystemExit):
        main(arguments)
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith('drake_geom_ros: ')
    assert words in last


def test_output_has_two_names(tmp_path, capsys):
    for name in ('--out', '--output'):
        assert main(['query', SCENE, name, str(tmp_path / f'{name}.csv')]) == 0
    one, other = sorted(tmp_path.iterdir())
    assert one.read_text() == other.read_text() != ''


def test_a_scene_may_come_from_the_standard_input(monkeypatch, capsys):
    assert main(['query', SCENE]) == 0
    expected = capsys.readouterr().out
    with open(SCENE, 'rb') as file:
        monkeypatch.setattr('sys.stdin', SimpleNamespace(buffer=file))
        assert main(['query', '-']) == 0
    assert capsys.readouterr().out == expected


@pytest.mark.parametrize(
    ('command', 'text', 'place'),
    [
        (['check', '-'], 'sources: [s]\nframes: 1\n', ':2: frames: '),
        (['check', '-'], '\xff', ':1: '),
        (['check', '-'], '<robot/>', ':1: missing attribute `name`'),
        (['query', SCENE, '--poses', '-'], 'time,frame\n', ':1: '),
        (['query', SCENE, '--poses', '-'], '[]', ': there is no moment in it'),
        (['query', SCENE, '--what', 'points', '--points', '-'], 'x,y,z\n', ': there is no point'),
    ],
)
def test_errors_name_the_standard_input(monkeypatch, capsys, command, text, place):
    monkeypatch.setattr('sys.stdin', SimpleNamespace(buffer=BytesIO(text.encode('latin-1'))))
    assert main(command) != 0
    assert f'standard input{place}' in capsys.readouterr().err


def test_the_standard_input_is_one_file(capsys):
    with pytest.raises(SystemExit):
        main(['query', '-', '--poses', '-'])
    assert 'can be one file only' in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.processes
def test_help_imports_no_geometry():
    script = (
        'import sys; from drake_geom_ros.programs import drake_geom_ros\n'
        'try: drake_geom_ros(["--help"])\n'
        'except SystemExit: print(sorted({"numpy", "numba", "rclpy"} & sys.modules.keys()))'
    )
    done = subprocess.run(
        [sys.executable, '-c', script], capture_output=True, text=True, timeout=800, check=True
    )
    assert done.stdout.splitlines()[-1] == '[]'
    for name in (*COMMANDS, 'node', 'status', 'viewer', 'player', 'demo', 'record'):
        assert f'    {name}' in done.stdout


@pytest.mark.parametrize('command', COMMANDS)
def test_each_command_explains_itself(capsys, command):
    with pytest.raises(SystemExit) as stop:
        main([command, '--help'])
    assert stop.value.code == 0
    assert f' {command} ' in capsys.readouterr().out.splitlines()[0] + ' '


def test_completion_knows_all_commands_and_their_options(capsys):
    pytest.importorskip('shtab')
    assert programs.drake_geom_ros(['completion', 'bash']) == 0
    script = capsys.readouterr().out
    listed = re.search(r'subparsers=\(([^)]*)\)', script)[1].replace("'", '').split()
    assert {*COMMANDS, 'node', 'status', 'viewer', 'player', 'demo', 'record'} == set(listed)
    assert '--max-distance' in script


def test_the_version_is_that_of_the_packages(capsys):
    with pytest.raises(SystemExit):
        main(['--version'])
    assert capsys.readouterr().out == f'drake_geom_ros {drake_geom_ros.__version__}\n'
    for file in ('package.xml', 'msg_defs/package.xml'):
        assert f'<version>{drake_geom_ros.__version__}</version>' in (ROOT / file).read_text()


def test_without_ros_a_program_of_ros_says_what_to_do(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, 'rclpy', None)
    for name in [name for name in sys.modules if name.startswith('drake_geom_ros.ros')]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, 'argv', ['before'])
    assert programs.drake_geom_ros(['status']) == 2
    assert 'status needs ROS 2, and there is no rclpy here' in capsys.readouterr().err


def test_a_program_that_lacks_an_extra_names_it(monkeypatch, capsys):
    def lacking():
        raise ModuleNotFoundError("No module named 'rosbags'", name='rosbags.typesys')

    monkeypatch.setitem(programs._OF_ROS, 'record', ('', lacking))
    monkeypatch.setattr(sys, 'argv', ['before'])
    assert programs.drake_geom_ros(['record']) == 2
    said = capsys.readouterr().err
    assert (
        said == "drake_geom_ros: record needs rosbags: pip install 'drake_geom_ros[recordings]'\n"
    )


def test_a_scene_of_a_node_that_is_not_there_is_refused_at_once(capsys):
    assert programs.drake_geom_ros(['node', '/nowhere.yaml']) == 2
    assert (
        capsys.readouterr().err == 'drake_geom_ros: /nowhere.yaml: there is no such scene file\n'
    )


def test_a_scene_behind_node_is_its_parameter(monkeypatch, tmp_path):
    seen = []
    (tmp_path / 'cell.yaml').touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, 'argv', ['before'])
    monkeypatch.setitem(programs._OF_ROS, 'node', ('', lambda: seen.append(sys.argv[1:]) or 0))
    assert programs.drake_geom_ros(['node', 'cell.yaml', '--ros-args', '-p', 'rate:=5.0']) == 0
    assert programs.drake_geom_ros(['node', '--ros-args']) == 0
    assert seen == [
        ['--ros-args', '-p', 'scene_file:=cell.yaml', '--', '--ros-args', '-p', 'rate:=5.0'],
        ['--ros-args'],
    ]
