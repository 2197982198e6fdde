"""The plug-ins of this folder, seen by small runs of pytest in a folder of their own."""

import os
import re
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytestmark = pytest.mark.processes

CONFTEST = """
pytest_plugins = ['plugins.marks', 'plugins.tiers', 'plugins.costs', 'plugins.reruns',
    'plugins.reversed']
"""
SETTINGS = '[pytest]\nmarkers = processes\n    topics\n    clock\n    packaging\n    everything\n'
# Fails when it is first run, in whichever process, and passes from then on.
ONCE = """
from pathlib import Path

def fail_once(name):
    runs = Path(__file__).with_name(name)
    count = int(runs.read_text()) if runs.exists() else 0
    runs.write_text(str(count + 1))
    assert count, 'the first time'
"""


@pytest.fixture
def run(tmp_path):
    """Return a function that runs the tests of a text, and returns exit code and output."""
    (tmp_path / 'conftest.py').write_text(CONFTEST)
    (tmp_path / 'pytest.ini').write_text(SETTINGS)

    def run(text, *options):
        (tmp_path / 'test_it.py').write_text(f'import pytest\n{ONCE}\n{text}')
        environment = {**os.environ, 'PYTHONPATH': str(ROOT / 'test')}
        environment = {
            name: value for name, value in environment.items() if not name.startswith('PYTEST_')
        }
        done = subprocess.run(
            [sys.executable, '-m', 'pytest', '-p', 'no:cacheprovider', *options],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout + done.stderr

    return run


@pytest.mark.parametrize(
    ('mark', 'options'),
    [('processes', ()), ('topics', ()), ('clock', ()), ('processes', ('-n', '2'))],
    ids=lambda value: value if isinstance(value, str) else 'alone' if not value else 'two workers',
)
def test_a_race_that_passes_alone_is_named_and_the_run_stays_green(run, tmp_path, mark, options):
    code, output = run(f"@pytest.mark.{mark}\ndef test_race(): fail_once('runs')", *options)
    assert code == 0, output
    assert '1 flaky in' in output
    assert 'flaky: test_it.py::test_race (first failure: AssertionError: the first time' in output
    assert (tmp_path / 'runs').read_text() == '2'
    (log,) = (tmp_path / 'log/flaky').iterdir()
    text = log.read_text()
    assert 'the first time' in text
    assert '1 passed' in text.partition('Alone:')[2]


def test_a_race_in_a_fixture_is_run_again_too(run):
    code, output = run("""
@pytest.fixture
def place(): fail_once('runs')

@pytest.mark.topics
def test_race(place): pass
""")
    assert code == 0, output
    assert '1 flaky in' in output


def test_what_fails_alone_too_is_red(run):
    code, output = run('@pytest.mark.topics\ndef test_broken(): assert False')
    assert code == 1
    assert '1 failed in' in output
    assert 'flaky:' not in output


def test_a_pure_test_never_runs_again(run, tmp_path):
    code, output = run("def test_pure(): fail_once('runs')")
    assert code == 1
    assert '1 failed in' in output
    assert (tmp_path / 'runs').read_text() == '1'


def test_a_race_beside_a_pure_failure_is_named_and_the_run_is_red(run):
    code, output = run("""
def test_pure(): assert False

@pytest.mark.clock
def test_race(): fail_once('runs')
""")
    assert code == 1
    assert '1 failed, 1 flaky in' in output
    assert 'flaky: test_it.py::test_race' in output


def test_a_race_beside_a_file_that_cannot_be_imported_is_named_and_the_run_is_red(run, tmp_path):
    (tmp_path / 'test_broken.py').write_text('import nowhere')
    body = "@pytest.mark.topics\ndef test_race(): fail_once('runs')"
    code, output = run(body, '-n', '2', '--continue-on-collection-errors')
    assert code == 1, output
    assert 'flaky: test_it.py::test_race' in output
    assert 'ERROR test_broken.py' in output
    assert 'KeyError' not in output


def test_more_than_five_races_are_red_and_none_runs_again(run, tmp_path):
    code, output = run("""
@pytest.mark.parametrize('name', 'abcdef')
@pytest.mark.topics
def test_race(name): fail_once(f'runs_{name}')
""")
    assert code == 1
    assert '6 failed in' in output
    assert '6 tests of processes, topics or clocks failed' in output
    assert (tmp_path / 'runs_a').read_text() == '1'


def test_who_starts_a_process_without_the_mark_fails(run):
    body = "def test_it(): __import__('subprocess').run(['true'])"
    code, output = run(body)
    assert code == 1
    assert 'lacks the mark `processes`' in output
    assert run(f'@pytest.mark.processes\n{body}')[0] == 0


def test_a_module_that_starts_a_process_when_it_is_imported_needs_no_mark(run, tmp_path):
    (tmp_path / 'asks.py').write_text("__import__('subprocess').run(['true'])")
    code, output = run("def test_it(): import sys; sys.path.insert(0, '.'); import asks")
    assert code == 0, output


def test_the_fixtures_of_a_node_imply_its_mark(run):
    code, output = run("""
@pytest.fixture
def lone_client(): return None

def test_it(lone_client, request): assert request.node.get_closest_marker('topics')
""")
    assert code == 0, output


@pytest.mark.parametrize('mark', ['packaging', 'everything'])
def test_what_takes_long_is_run_by_everything_alone(run, mark):
    text = f'def test_short(): pass\n\n@pytest.mark.{mark}\ndef test_long(): pass'
    assert '1 passed, 1 deselected' in run(text)[1]
    assert '2 passed' in run(text, '--everything')[1]


def test_files_run_in_reversed_order_and_the_tests_of_each_in_their_own(run, tmp_path):
    (tmp_path / 'test_first.py').write_text('def test_one(): pass\n\ndef test_two(): pass\n')
    for options, names in (
        ([], ['one', 'two', 'last']),
        (['--reversed'], ['last', 'one', 'two']),
    ):
        output = run('def test_last(): pass', '-v', *options)[1]
        assert re.findall(r'::test_(\w+) PASSED', output) == names


@pytest.mark.parametrize('options', [(), ('-n', '2')], ids=['one process', 'two workers'])
def test_the_costs_are_added_up_by_folder_file_and_kind(run, tmp_path, options):
    code, output = run(
        """
def test_pure():
    import time
    begin = time.process_time()
    while time.process_time() < begin + 1.0: pass

@pytest.mark.topics
def test_topic(): pass
""",
        '--costs=costs.md',
        *options,
    )
    assert code == 0, output
    rows = [line.split(' | ') for line in (tmp_path / 'costs.md').read_text().splitlines()]
    kinds = {row[0].strip('| '): row[1:] for row in rows if len(row) == 5}
    assert kinds['topics'][0] == kinds['pure'][0] == '1'
    assert float(kinds['pure'][2]) >= 1.0
    assert kinds['test_it.py'][0] == '2'
