"""`run` sets up what its inputs ask for: once, again when they change, on from where it broke."""

import contextlib
import os
import re
import shutil
import signal
import socket
import subprocess
import time

import pytest
from conventions.run_shell import FAKE_STEPS, calls, ended, folder, shell, start
from conventions.source_tree import ROOT

__all__ = ['folder']  # a fixture

pytestmark = [pytest.mark.packaging, pytest.mark.processes]


def keys(folder, **variables):
    script = 'compute_keys; echo "$venv_key" "$packages_key" "$messages_key" "$tf2_msgs_key"'
    code, output, errors = shell(folder, script, **variables)
    assert code == 0, errors
    return output.split()


def append(path, text):
    path.write_text(path.read_text() + text)


@pytest.mark.parametrize('script', ['run', '.ci/run'])
def test_the_scripts_parse_and_may_be_started(script):
    assert os.access(ROOT / script, os.X_OK)
    assert subprocess.run(['bash', '-n', ROOT / script], check=False).returncode == 0


def test_help_names_every_command():
    shown = subprocess.run(
        [ROOT / 'run', 'help'], capture_output=True, text=True, check=True
    ).stdout
    table = (ROOT / 'run').read_text().split('case $command in')[1]
    commands = set(re.findall(r'^  (\w+)\)', table, re.MULTILINE))
    assert commands >= {'demo', 'test', 'node', 'exec', 'clean'}
    assert {name for name in commands if f'./run {name}' not in shown} == set()


def test_an_unknown_command_is_named():
    result = subprocess.run([ROOT / 'run', 'dmeo'], capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "unknown command 'dmeo'" in result.stderr


@pytest.mark.parametrize(
    ('file', 'changed'),
    [
        ('requirements/core.txt', [False, True, False, False]),
        ('requirements/lock.txt', [False, True, False, False]),
        ('requirements/peers.txt', [False, False, False, False]),
        ('requirements/test.txt', [False, False, False, False]),
        ('requirements/lint.txt', [False, False, False, False]),
        ('requirements/mutants.txt', [False, False, False, False]),
        ('requirements/cluster.txt', [False, False, False, False]),
        ('requirements/view.txt', [False, False, False, False]),
        ('requirements/vtk.txt', [False, False, False, False]),
        ('requirements/recordings.txt', [False, False, False, False]),
        ('requirements/wheels.txt', [False, False, False, False]),
        ('requirements/kilted/ros.txt', [False, True, True, True]),
        ('requirements/kilted/lock.txt', [False, True, True, True]),
        ('requirements/jazzy/ros.txt', [False, False, False, False]),
        ('requirements/build.txt', [False, True, True, True]),
        ('msg_defs/msg/Shape.msg', [False, False, True, True]),
        ('msg_defs/CMakeLists.txt', [False, False, True, True]),
        ('test/msg_defs/tf2_msgs/package.xml', [False, False, False, True]),
    ],
)
def test_a_changed_input_changes_the_keys_of_what_depends_on_it(folder, file, changed):
    before = keys(folder)
    append(folder / file, '# changed\n')
    assert [a != b for a, b in zip(before, keys(folder), strict=True)] == changed


def test_a_renamed_definition_changes_the_key(folder):
    before = keys(folder)
    (folder / 'msg_defs/msg/Shape.msg').rename(folder / 'msg_defs/msg/Form.msg')
    assert keys(folder)[2] != before[2]


def test_a_newer_date_changes_no_key(folder):
    before = keys(folder)
    (folder / 'msg_defs/msg/Shape.msg').touch()
    assert keys(folder) == before


def test_a_sourced_distribution_changes_all_keys(folder, tmp_path_factory):
    distribution = tmp_path_factory.mktemp('distribution')
    (distribution / 'share/rclpy').mkdir(parents=True)
    (distribution / 'share/rclpy/package.xml').touch()
    plain, sourced = keys(folder), keys(folder, AMENT_PREFIX_PATH=f'/nowhere:{distribution}')
    assert [a != b for a, b in zip(plain, sourced, strict=True)] == [True] * 4


def test_the_own_environment_is_no_distribution(folder):
    (folder / '.venv/share/rclpy').mkdir(parents=True)
    (folder / '.venv/share/rclpy/package.xml').touch()
    assert keys(folder, AMENT_PREFIX_PATH=str(folder / '.venv')) == keys(folder)


def test_jazzy_has_an_environment_beside_that_of_kilted(folder):
    plain, jazzy = keys(folder), keys(folder, ROS_DISTRO='jazzy')
    assert [a != b for a, b in zip(plain, jazzy, strict=True)] == [True] * 4
    append(folder / 'requirements/jazzy/ros.txt', '# changed\n')
    changed = [a != b for a, b in zip(jazzy, keys(folder, ROS_DISTRO='jazzy'), strict=True)]
    assert changed == [False, True, True, True]
    script = (
        'for place in "$venv" "$prefix" "$tf2_msgs" "$builds"; do echo "${place#$root/}"; done'
    )
    places = [shell(folder, script, **given)[1].split() for given in ({}, {'ROS_DISTRO': 'jazzy'})]
    assert places[0] == [
        *('.venv', 'install/drake_geom_msgs', 'install/for_tests/tf2_msgs', 'build')
    ]
    assert places[1] == ['.venv-jazzy', *(f'.venv-jazzy/{place}' for place in places[0][1:])]


def test_a_sourced_distribution_is_used_whatever_its_name(folder, tmp_path_factory):
    distribution = tmp_path_factory.mktemp('distribution')
    (distribution / 'share/rclpy').mkdir(parents=True)
    (distribution / 'share/rclpy/package.xml').touch()
    given = {'AMENT_PREFIX_PATH': str(distribution), 'ROS_DISTRO': 'rolling'}
    code, output, errors = shell(folder, 'compute_keys; echo "$venv"', **given)
    assert (code, output.strip()) == (0, str(folder.resolve() / '.venv')), errors


def test_a_distribution_that_pypi_has_not_is_refused_with_those_that_it_has(folder):
    code, _, errors = shell(folder, 'compute_keys', ROS_DISTRO='humble')
    assert code == 1
    assert 'ROS_DISTRO=humble is none of: jazzy kilted' in errors


def test_steps_run_once_and_in_order(folder):
    for _ in range(2):
        code, _, errors = shell(folder, FAKE_STEPS + 'set_up')
        assert code == 0, errors
    assert calls(folder) == ['venv', 'tools', 'messages']
    assert (folder / 'beside').read_text() == 'packages\nkernels\n'


def test_what_is_ended_as_soon_as_it_is_forked_does_not_end_the_kernels(folder):
    """As the heartbeat of messages that are there at once: bash runs inherited traps in it."""
    steps = """
logged() {
  local i
  if [[ $1 == kernels ]]; then until [[ -e $prefix ]]; do sleep 0.1; done; fi
  if [[ $1 == messages ]]; then
    for i in {1..50}; do sleep 1 & kill "$!"; wait "$!" || true; done
  fi
  "$2"
}
"""
    code, _, errors = shell(folder, FAKE_STEPS + steps + 'set_up')
    assert code == 0, errors
    assert (folder / 'beside').read_text() == 'packages\nkernels\n'


def test_messages_are_built_while_packages_are_on_their_way(folder):
    waits = """
install_packages() {
  for _ in {1..600}; do [[ ! -e $prefix ]] || return 0; sleep 0.1; done
  false
}
"""
    code, _, errors = shell(folder, FAKE_STEPS + waits + 'set_up')
    assert code == 0, errors


BUSY = 'compile_kernels() { echo $BASHPID >"$root/busy"; sleep 60; }\n'


def test_kernels_are_compiled_no_longer_where_the_messages_fail(folder):
    broken = 'build_messages() { until [[ -s $root/busy ]]; do sleep 0.1; done; false; }\n'
    code, _, errors = shell(folder, FAKE_STEPS + BUSY + broken + 'set_up')
    assert code == 1
    assert "step 'messages' failed" in errors
    assert ended(folder)


def test_an_interrupt_ends_both_steps(folder):
    slow = 'build_messages() { sleep 60; }\n'
    process = start(folder, FAKE_STEPS + BUSY + slow + 'set_up')
    while not (folder / 'busy').exists() or not (folder / 'busy').read_text():
        assert process.poll() is None
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, errors = process.communicate(timeout=800)
    assert process.returncode == 130
    assert 'the next ./run goes on from here' in errors
    assert ended(folder)


def test_kernels_that_do_not_compile_are_told(folder):
    broken = 'compile_kernels() { echo "Error: no compiler"; false; }\n'
    code, _, errors = shell(folder, FAKE_STEPS + broken + 'set_up')
    assert code == 1
    assert "step 'kernels' failed" in errors
    assert calls(folder) == ['venv', 'tools', 'messages']


def test_the_kernels_of_other_shapes_are_compiled_once_and_beside_what_runs(folder):
    slow = 'until [[ -e $root/go ]]; do sleep 0.1; done; echo others >>"$root/others"'
    script = FAKE_STEPS + f'compile_all() {{ {slow}; }}\n' + 'prepare free_domain'
    code, _, errors = shell(folder, script)  # which does not wait for it
    assert code == 0, errors
    assert 'compiled beside this' in errors
    assert not (folder / 'others').exists()
    (folder / 'go').touch()
    code, _, errors = shell(folder, script + '; others')  # who measures waits
    assert code == 0, errors
    assert (folder / 'others').read_text() == 'others\n'
    assert 'beside this' not in shell(folder, script)[2]


def test_programs_are_found_under_run_though_a_folder_has_their_name(folder):
    shutil.copytree(ROOT / 'scripts', folder / 'scripts')
    (folder / 'drake_geom_ros').mkdir()
    code, out, errors = shell(folder, FAKE_STEPS + 'prepare free_domain; type -p drake_geom_ros')
    assert code == 0, errors
    assert out.strip() == str(folder / 'scripts/drake_geom_ros')


def test_only_the_tests_ask_for_the_messages_of_tf_and_once(folder):
    for _ in range(2):
        code, _, errors = shell(folder, FAKE_STEPS + 'set_up; prepare_with_tf free_domain')
        assert code == 0, errors
    assert calls(folder) == ['venv', 'tools', 'messages', 'tf2_msgs']


SETS = {
    *(
        'cluster',
        'docs',
        'examples',
        'lint',
        'mutants',
        'peers',
        'recordings',
        'test',
        'view',
        'vtk',
    ),
    'wheels',
}


def test_every_set_of_packages_that_tests_import_is_there_for_them(folder):
    """What nobody installs is skipped wherever the tests run: those of recordings once were."""
    always = {'core', 'demo', 'build', 'lock'}
    files = {path.stem for path in (folder / 'requirements').glob('*.txt')}
    assert files - always == SETS
    code, said, errors = shell(folder, 'echo "${test_sets[@]}"; declare -F')
    assert code == 0, errors
    sets, *functions = said.splitlines()
    assert {*sets.split(), 'mutants', 'wheels'} == SETS
    assert {f'declare -f install_{name}' for name in SETS} <= {*functions}


@pytest.mark.parametrize('name', sorted(SETS))
def test_a_further_set_is_installed_for_its_command_and_when_its_pins_change(folder, name):
    script = FAKE_STEPS + f'install_{name}() {{ echo {name} >>"$root/calls"; }}\n'
    for change in ('', '', '# changed\n'):
        append(folder / f'requirements/{name}.txt', change)
        code, _, errors = shell(folder, script + f'prepare_with {name}')
        assert code == 0, errors
    assert calls(folder) == ['venv', 'tools', 'messages', name, name]


@pytest.mark.parametrize(
    ('uv_can', 'variables', 'asked'),
    [
        (True, {}, ['uv pip install --python PYTHON -c pins numpy']),
        (
            True,
            {'PIP_INDEX_URL': 'https://mirror/simple'},
            ['uv pip install --python PYTHON --default-index https://mirror/simple -c pins numpy'],
        ),
        (False, {}, ['uv pip install --python PYTHON -c pins numpy', 'pip -c pins numpy']),
        (True, {'underlay': '/opt/ros/kilted'}, ['pip -c pins numpy']),
    ],
)
def test_packages_are_installed_by_uv_or_where_it_cannot_by_pip(folder, uv_can, variables, asked):
    programs = folder / '.venv/bin'
    programs.mkdir(parents=True)
    python, uv = programs / 'python', programs / 'uv'
    python.write_text('#!/bin/bash\n[[ $3 == install ]] && echo pip "${@:8}" >>calls')
    uv.write_text(f'#!/bin/bash\necho uv "$@" >>calls; exit {int(not uv_can)}')
    for program in (python, uv):
        program.chmod(0o755)
    underlay = variables.pop('underlay', '')
    script = f'venv=.venv underlay={underlay}\nadd_to .venv/bin/python -c pins numpy'
    code, _, errors = shell(folder, script, **variables)
    assert code == 0, errors
    said = (folder / 'calls').read_text().replace('.venv/bin/python', 'PYTHON')
    assert said.splitlines() == asked


def test_a_package_without_a_wheel_is_left_out_but_not_all_of_them(folder):
    script = 'pip_add() { [[ ${*: -1} == there ]]; }\npip_add_wheels cluster '
    assert [shell(folder, script + names)[0] for names in ('there not', 'not')] == [0, 1]


@pytest.mark.parametrize(
    ('uid', 'fetched', 'said'),
    [
        (0, 'false', 'cannot be fetched: chromium'),
        (0, 'true', 'installed'),
        (1000, 'true', 'only root'),
    ],
)
def test_a_browser_is_installed_where_it_can_be_and_never_fails(folder, uid, fetched, said):
    there = 'command() { [[ $2 == apt-get ]]; }\n'
    root = f'id() {{ echo {uid}; }}\n'
    apt = f'timeout() {{ {fetched} && "${{@:4}}"; }}\napt-get() {{ echo installed; }}\n'
    code, out, errors = shell(folder, there + root + apt + 'install_browser')
    assert code == 0, errors
    assert said in out


@pytest.mark.parametrize(
    ('command', 'sets'),
    [
        ('python -m pytest -q test/math', 'test'),
        ('pytest', 'test'),
        ('.venv/bin/pytest -x', 'test'),
        ('python -m bench.costs.filters', 'test'),
        ('python -m bench.viewer.pictures --node', 'test view'),
        ('python docs/generate_reference.py', 'test'),
        ('mkdocs build', 'test docs'),
        ('ruff check', 'lint'),
        ('python -m mypy', 'lint'),
        ('python my_pytest.py', ''),
        ('scene_viewer', 'view'),
        ('scene_viewer --ros-args -p port:=8090', 'view'),
        ('drake_geom_ros viewer', 'view'),
        ('drake_geom_ros demo --forever --view', 'view'),
        ('drake_geom_ros demo --seconds 5', ''),
        ('python -m drake_geom_ros view cell.yaml', 'view'),
        ('drake_geom_ros report run_1 --scene cell.yaml', 'recordings'),
        ('record --seconds 5', 'recordings'),
        ('drake_geom_ros replay record.json', ''),
        ('drake_geom_ros completion bash', 'test'),
        ('drake_geom_ros batch cell.yaml states.npy --out x.npz', ''),
        ('drake_geom_ros batch cell.yaml states.npy --cluster tcp://a:1', 'cluster'),
        ('drake_geom_ros report run_1 --cluster=tcp://a:1', 'recordings cluster'),
        ('python examples/plan_an_arm.py --edges samples', 'examples'),
        ('drake_geom_ros query cell.yaml', ''),
    ],
)
def test_exec_installs_what_its_command_asks_for_by_its_name(folder, command, sets):
    code, said, errors = shell(folder, f'sets_of {command}')
    assert code == 0, errors
    assert ' '.join(said.split()) == sets


def test_exec_installs_what_its_script_imports(folder):
    for name, text, sets in (
        ('write_run.py', 'import sys\nfrom rosbags.rosbag2 import Writer\n', 'recordings'),
        ('meshcat.py', 'from drake_geom_ros.viewing.meshcat import StartMeshcat\n', 'view'),
        ('plain.py', 'import numpy as np\n# import rosbags\n', ''),
    ):
        (folder / name).write_text(text)
        code, said, errors = shell(folder, f'sets_of python {name} 1.2')
        assert code == 0, errors
        assert said.strip() == sets


def test_what_was_deleted_is_made_again(folder):
    shell(folder, FAKE_STEPS + 'set_up')
    shutil.rmtree(folder / 'install')
    shell(folder, FAKE_STEPS + 'set_up')
    assert calls(folder) == ['venv', 'tools', 'messages', 'messages']


def test_a_failed_step_says_which_why_and_where_and_is_taken_up_again(folder):
    broken = 'install_packages() { echo "ERROR: no such package"; false; echo not reached; }\n'
    code, _, errors = shell(folder, FAKE_STEPS + broken + 'set_up')
    assert code == 1
    assert "step 'packages' failed" in errors
    assert 'ERROR: no such package' in errors
    assert 'this failed: false' in errors
    log = folder / 'log/setup/packages.log'
    assert str(log) in errors
    assert 'not reached' not in log.read_text()
    code, _, errors = shell(folder, FAKE_STEPS + 'set_up')
    assert code == 0, errors
    assert calls(folder) == ['venv', 'tools', 'messages']


def test_a_killed_set_up_is_taken_up_again(folder):
    killed = 'install_tools() { kill -KILL -- -$$; }\n'
    code, _, _ = shell(folder, FAKE_STEPS + killed + 'set_up')
    assert code == -9
    code, _, errors = shell(folder, FAKE_STEPS + 'set_up')
    assert code == 0, errors
    assert calls(folder) == ['venv', 'tools', 'messages']


def test_of_two_at_once_one_sets_up_and_the_other_waits(folder):
    both = [start(folder, FAKE_STEPS + 'set_up') for _ in range(2)]
    errors = [process.communicate(timeout=800)[1] for process in both]
    assert [process.returncode for process in both] == [0, 0], errors
    assert calls(folder) == ['venv', 'tools', 'messages']


@pytest.mark.parametrize('version', ['3.9.18', '3.14.0', '2.7.18', ''])
def test_an_unsupported_python_is_refused(folder, version):
    code, _, _ = shell(folder, f'supported "{version}"')
    assert code == 1


@pytest.mark.parametrize('version', ['3.10.13', '3.11.2', '3.12.3', '3.13.0'])
def test_the_supported_pythons_are_taken(folder, version):
    code, _, errors = shell(folder, f'supported "{version} /usr"')
    assert code == 0, errors


def test_no_python_is_said_with_what_was_tried(folder):
    code, _, errors = shell(folder, 'compute_keys', PYTHON='/nowhere/python')
    assert code == 1
    assert 'no Python 3.10 to 3.13 among: /nowhere/python' in errors


def test_a_domain_in_use_is_not_taken(folder):
    sockets = []
    try:
        for domain in range(1, 101):
            sockets.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            sockets[-1].setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            with contextlib.suppress(OSError):  # somebody else has it: taken all the same
                sockets[-1].bind(('127.0.0.1', 7400 + 250 * domain))
        code, output, errors = shell(folder, 'free_domain')
    finally:
        for each in sockets:
            each.close()
    assert (code, output.strip()) == (0, '101') or 'all ROS domains' in errors


def test_node_and_exec_of_a_folder_share_a_domain(folder):
    first, second = (shell(folder, 'folder_domain')[1] for _ in range(2))
    assert first == second
    assert 1 <= int(first) <= 101


@pytest.mark.parametrize(
    ('given', 'expected'),
    [
        ({}, 'LOCALHOST|'),
        ({'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}, 'LOCALHOST|'),
        ({'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp'}, 'SYSTEM_DEFAULT|{}/config/fastdds.xml'),
        (
            {
                'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp',
                'FASTDDS_DEFAULT_PROFILES_FILE': 'my.xml',
            },
            'LOCALHOST|my.xml',
        ),
    ],
)
def test_fast_dds_does_without_shared_memory_unless_told_otherwise(folder, given, expected):
    shown = '$ROS_AUTOMATIC_DISCOVERY_RANGE|${FASTDDS_DEFAULT_PROFILES_FILE:-}'
    script = f'enter() {{ :; }}; underlay=x; prepare_environment; echo "{shown}"'
    code, output, errors = shell(folder, script, AMENT_PREFIX_PATH='', **given)
    assert code == 0, errors
    assert output == expected.format(folder.resolve()) + '\n'


def test_folders_of_packages_are_kept(folder):
    """Of prefixes without ROS only package:// has use: for robots, wherever they are built."""
    script = (
        'enter() { :; }; underlay=; prepare_environment; prepare_environment; '
        'echo "$AMENT_PREFIX_PATH|$ROS_PACKAGE_PATH"'
    )
    given = {'AMENT_PREFIX_PATH': '/my/arms', 'ROS_PACKAGE_PATH': '/my/src'}
    code, output, errors = shell(folder, script, **given)
    assert code == 0, errors
    assert output == f'{folder.resolve()}/.venv:/my/arms|/my/src\n'
