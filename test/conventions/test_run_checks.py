"""What `run test` checks, and how: the ends of the supported range, OpenVDB, the other ROS."""

import os
import re
import signal
import time

import pytest
from conventions.run_shell import FAKE_STEPS, calls, ended, folder, shell, start
from conventions.source_tree import ROOT

__all__ = ['folder']  # a fixture

pytestmark = [pytest.mark.packaging, pytest.mark.processes]


def python_of(folder, version):
    """Write an interpreter that says that it is of a version, and return its folder."""
    path = folder / f'bin-{version}' / f'python{version}'
    path.parent.mkdir()
    path.write_text(f'#!/bin/sh\necho {version}.1 /nowhere\n')
    path.chmod(0o755)
    return path.parent


# A main environment of 3.11, steps that only say what they would do, and checks that pass.
FAKE_ENDS = """
mkdir -p "$venv/bin" "$root/home"; HOME=$root/home; unset PYENV_ROOT
printf '#!/bin/sh\\necho 3.11.9 /nowhere\\n' >"$venv/bin/python"; chmod +x "$venv/bin/python"
step() { echo "$1" >>"$root/steps"; }
python() { echo "$2" >>"$root/checks"; }
test_core() { echo "core $1" >>"$root/checks"; [[ $1 != "${breaks:-}" ]]; }
prepare_ends; run_tests
"""


def test_the_core_is_tested_under_the_ends_of_the_supported_range(folder):
    found = [python_of(folder, version) for version in ('3.10', '3.13')]
    path = ':'.join([*map(str, found), os.environ['PATH']])
    code, _, errors = shell(folder, FAKE_ENDS, PATH=path)
    assert code == 0, errors
    assert 'pytest ok, core on Python 3.10 ok, core on Python 3.13 ok' in errors
    assert (folder / 'steps').read_text().split() == ['core-3.10', 'core-3.13']
    code, _, errors = shell(folder, 'breaks=3.13\n' + FAKE_ENDS, PATH=path)
    assert code == 1
    assert 'pytest ok, core on Python 3.10 ok, core on Python 3.13 FAILED' in errors


def test_the_oldest_python_has_the_oldest_packages_and_the_newest_the_newest(folder):
    for version in ('3.10', '3.13'):
        python_of(folder, version)
    (folder / '.venv/bin').mkdir(parents=True)
    uv = folder / '.venv/bin/uv'
    uv.write_text('#!/bin/sh\necho "$@" >>"$root/asked"\n')
    uv.chmod(0o755)
    path = f'{folder}/bin-3.10:{folder}/bin-3.13:/usr/bin:/bin'
    script = FAKE_ENDS.replace('step() {', 'index_of_pip() { :; }; export root; step() { "$4";')
    code, _, errors = shell(folder, script, PATH=path)
    assert code == 0, errors
    asked = (folder / 'asked').read_text().splitlines()
    oldest, newest, drake = (line for line in asked if line.startswith('pip install'))
    assert 'core-3.13/' in drake
    assert drake.endswith('--only-binary :all: drake')
    assert 'core-3.10/' in oldest
    assert '--resolution lowest-direct' in oldest
    assert 'core-3.13/' in newest
    assert '--resolution highest' in newest
    assert all(line.endswith(f'-e {folder.resolve()}[test]') for line in (oldest, newest))


# Two cores that say something, each when the other has begun.
SIDES = """
test_core() {
  echo "$1 begins"
  echo "$1" >>"$root/begun"
  until (($(wc -l <"$root/begun") == 2)); do sleep 0.1; done
  echo "$1 ends"
  [[ $1 != "${breaks:-}" ]]
}
python() { :; }
ends=(3.10 3.13) missing=()
"""


@pytest.mark.parametrize(('breaks', 'code'), [('', 0), ('3.10', 1), ('3.13', 1)])
def test_checks_run_side_by_side_and_each_is_shown_in_one_piece(folder, breaks, code):
    done, output, errors = shell(folder, f'breaks={breaks}\n{SIDES}run_tests')
    assert done == code, errors
    found = [f'core on Python {v} {"FAILED" if v == breaks else "ok"}' for v in ('3.10', '3.13')]
    assert ', '.join(['mypy ok', 'pytest ok', *found]) in errors
    shown = [line for line in output.splitlines() if line.endswith(('begins', 'ends'))]
    assert shown == ['3.10 begins', '3.10 ends', '3.13 begins', '3.13 ends']
    assert '3.10 ends' in (folder / 'log/beside/core-3.10.log').read_text()


def test_a_check_beside_that_is_ended_has_failed(folder):
    killed = 'test_core() { echo "$1 begins"; [[ $1 != 3.13 ]] || kill -KILL $BASHPID; }\n'
    code, output, errors = shell(folder, SIDES + killed + 'run_tests')
    assert code == 1
    assert 'pytest ok, core on Python 3.10 ok, core-3.13 FAILED' in errors
    assert '3.13 begins' in output


def test_an_interrupt_ends_the_checks_beside(folder):
    waits = 'test_core() { echo $BASHPID >"$root/busy"; sleep 60; }\n'
    process = start(folder, SIDES + waits + 'ends=(3.10); run_tests')
    while not (folder / 'busy').exists() or not (folder / 'busy').read_text():
        assert process.poll() is None
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    process.communicate(timeout=800)
    assert process.returncode != 0
    assert ended(folder)


def test_kernels_of_other_shapes_and_messages_of_tests_are_made_side_by_side(folder):
    """Each ends when the other has begun."""
    wait = '{ echo >"$root/NAME"; until [[ -e $root/OTHER ]]; do sleep 0.1; done; }\n'
    steps = 'compile_all() ' + wait.replace('NAME', 'a').replace('OTHER', 'b')
    steps += 'build_tf2_msgs() ' + wait.replace('NAME', 'b').replace('OTHER', 'a')
    steps += 'test_sets=(test); run_tests() { [[ -s $venv/.stamp-others ]] && echo "tests $*"; }\n'
    code, output, errors = shell(folder, FAKE_STEPS + steps + 'test_command test/math')
    assert code == 0, errors
    assert output == 'tests test/math\n'


def test_kernels_of_other_shapes_that_do_not_compile_end_the_tests(folder):
    steps = 'compile_all() { echo "Error: no compiler"; false; }\n'
    steps += 'test_sets=(test); run_tests() { echo tests; }\n'
    code, output, errors = shell(folder, FAKE_STEPS + steps + 'test_command')
    assert (code, output) == (1, '')
    assert "step 'others' failed" in errors
    assert 'Error: no compiler' in errors


@pytest.mark.parametrize(
    ('openvdb', 'code', 'said'),
    [
        ('openvdb=$root/there', 0, 'fields for OpenVDB ok'),
        ('openvdb=$root/broken', 1, 'fields for OpenVDB FAILED'),
        ("openvdb=''", 0, 'fields for OpenVDB NOT RUN (no python3-openvdb here)'),
        ('unset openvdb', 0, 'ruff check ok'),
    ],
)
def test_fields_for_openvdb_are_tested_where_its_module_is(folder, openvdb, code, said):
    checks = 'python() { :; }; test_in() { [[ $1 == *there ]]; }; ends=() missing=()\n'
    done, _, errors = shell(folder, checks + openvdb + '\nrun_tests')
    assert done == code, errors
    last = errors.rstrip().splitlines()[-1]
    assert said in last
    assert ('OpenVDB' in last) == ('OpenVDB' in said)


def test_without_openvdb_no_environment_is_made_for_it(folder):
    """The system's Python is there, and nothing brings the module."""
    script = 'compute_keys() { :; }; apt_try() { echo "asked for $*" >>"$root/asked"; }\n'
    script += 'index_of_pip() { :; }; prepare_openvdb; echo "<$openvdb>"'
    (folder / 'pyopenvdb.py').write_text('raise ImportError')
    code, output, errors = shell(folder, script, PYTHONPATH=str(folder))
    assert code == 0, errors
    assert output.endswith('<>\n')
    assert (folder / 'asked').read_text() == 'asked for python3-openvdb\n'


def test_an_interpreter_that_is_missing_is_named_in_the_closing_line(folder):
    path = f'{python_of(folder, "3.10")}:/usr/bin:/bin'
    code, _, errors = shell(folder, 'ends_of_range=(3.10 3.99)' + FAKE_ENDS, PATH=path)
    assert code == 0, errors
    last = errors.rstrip().splitlines()[-1]
    assert 'core on Python 3.99 NOT RUN (no such interpreter here)' in last


def test_what_only_bears_the_name_of_a_version_is_no_interpreter_of_it(folder):
    """As the shims of a version manager, which end with an error."""
    shim = python_of(folder, '3.13') / 'python3.13'
    shim.write_text('#!/bin/sh\nexit 127\n')
    (folder / 'home/.pyenv/versions/3.13.0/bin').mkdir(parents=True)
    real = python_of(folder / 'home', '3.13') / 'python3.13'
    real.rename(folder / 'home/.pyenv/versions/3.13.0/bin/python3.13')
    script = 'HOME=$root/home; unset PYENV_ROOT; find_version 3.13'
    code, output, errors = shell(folder, script, PATH=f'{shim.parent}:/usr/bin:/bin')
    assert code == 0, errors
    assert output.strip().endswith('.pyenv/versions/3.13.0/bin/python3.13')


def test_the_quick_tests_hold_a_file_of_each_room_of_the_core():
    lines = (ROOT / 'test/quick_core.txt').read_text().splitlines()
    files = [line for line in lines if not line.startswith('#')]
    assert [name for name in files if not (ROOT / name).is_file()] == []
    rooms = {'math', 'autodiffutils', 'sensors', 'common', 'scene_files', 'trajectories', 'batch'}
    rooms |= {'replay', 'command_line', 'geometry'}
    assert {name.split('/')[1] for name in files} >= rooms


# What one shell does for the other ROS, and the closing line of the other.
FAKE_JAZZY = """
mkdir -p test; echo '# which' >test/quick_ros.txt; echo test/ros/test_it.py >>test/quick_ros.txt
compile_all() { echo all >>"$root/others"; }
python() { echo "${venv##*/} $*" >>"$root/checks"; }
check_beside jazzy test_other_ros; run_tests
"""


def test_the_node_is_tested_on_jazzy_in_an_environment_of_its_own(folder):
    code, _, errors = shell(folder, FAKE_STEPS + FAKE_JAZZY)
    assert code == 0, errors
    assert 'mypy ok, pytest ok, node on ROS 2 Jazzy ok' in errors
    checks = (folder / 'checks').read_text().splitlines()
    (jazzy,) = (line for line in checks if line.startswith('.venv-jazzy '))
    assert jazzy.startswith('.venv-jazzy -m pytest')
    assert jazzy.endswith('test/ros/test_it.py')
    assert all(line.startswith('.venv -m ') for line in checks if line != jazzy)
    assert calls(folder) == ['venv', 'tools', 'messages', 'tf2_msgs']
    assert not (folder / 'others').exists()  # its few files compile what they use


@pytest.mark.parametrize('given', [{}, {'ROS_DOMAIN_ID': '5'}, {'ROS_DOMAIN_ID': '100'}])
def test_nodes_on_jazzy_meet_none_of_those_that_run_beside_them(folder, given):
    script = 'echo "${ROS_DOMAIN_ID:-$(free_domain)}"; domain_beside_pytest'
    code, output, errors = shell(folder, script, **given)
    assert code == 0, errors
    first, beside = map(int, output.split())
    own = {(first + 37 * worker + shared) % 101 for worker in range(3) for shared in (0, 18)}
    assert not own & {(beside + shared) % 101 for shared in (0, 18)}


@pytest.mark.parametrize(
    ('breaks', 'code', 'told'),
    [
        ('python() { [[ $venv != *jazzy || $* != *pytest* ]]; }', 1, 'FAILED'),
        ('build_messages() { false; }', 1, 'FAILED'),
        (
            'install_packages() { false; echo; }',
            0,
            'NOT RUN (its packages cannot be installed: log/setup-jazzy)',
        ),
    ],
)
def test_what_breaks_on_jazzy_is_told_in_the_closing_line(folder, breaks, code, told):
    script = FAKE_STEPS + FAKE_JAZZY.replace('check_beside', f'{breaks}\ncheck_beside')
    status, _, errors = shell(folder, script)
    assert (status, f'pytest ok, node on ROS 2 Jazzy {told}' in errors) == (code, True), errors


def test_jazzy_itself_or_another_distribution_is_not_tested_twice(folder):
    tell = '\ntest_other_ros; echo "[${verdict:-}]"'
    assert shell(folder, FAKE_STEPS + tell, ROS_DISTRO='jazzy')[1].strip() == '[]'
    told = shell(folder, FAKE_STEPS + '\nunderlay=/opt/ros' + tell)[1]
    assert 'NOT RUN (the ROS in /opt/ros is used)' in told


def test_the_quick_tests_of_a_ros_are_there():
    lines = (ROOT / 'test/quick_ros.txt').read_text().splitlines()
    files = [line for line in lines if not line.startswith('#')]
    assert len(files) >= 4
    assert [name for name in files if not (ROOT / name).is_file()] == []


def test_what_setup_supports_are_the_ends_that_are_tested():
    text = (ROOT / 'requirements/other_pythons.sh').read_text()
    oldest, newest = re.search(r'ends_of_range=\((\S+) (\S+)\)', text).groups()
    asked = re.search(r"python_requires='>=(\S+),<(\S+)'", (ROOT / 'setup.py').read_text())
    major, minor = newest.split('.')
    assert asked.groups() == (oldest, f'{major}.{int(minor) + 1}')
