import sys

import pytest

pytestmark = pytest.mark.processes

trials = pytest.importorskip('bench.mutants.trials', reason='./run mutants installs coverage')

SOURCE = """
import time

LIMIT = 7


def double(x):
    return x + x


class Thing:
    @property
    def size(self):
        return LIMIT

    @staticmethod
    def bounded(x):
        return [y for y in x if y < LIMIT]
"""
TESTS = """
from drake_geom_mutants.doubling import LIMIT, Thing, double
def test_double(): assert double(3) == 6
def test_limit(): assert LIMIT == 7
def test_thing(): assert Thing.bounded((6, 7)) == [6] and Thing().size == 7
"""
FILE = 'drake_geom_mutants/doubling.py'


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """Make a tree of one module and its tests, in place of ours."""
    for folder in ('drake_geom_mutants', 'test'):
        (tmp_path / folder).mkdir()
    (tmp_path / FILE).write_text(SOURCE)
    (tmp_path / 'test/test_doubling.py').write_text(TESTS)
    (tmp_path / 'test/test_elsewhere.py').write_text(TESTS)
    monkeypatch.setattr(trials, 'ROOT', tmp_path)
    monkeypatch.setattr(trials, 'TESTS', ('test',))
    path = f'{tmp_path}:{trials.__file__.removesuffix("/bench/mutants/trials.py")}'
    monkeypatch.setenv('PYTHONPATH', path)
    monkeypatch.setenv('PYTEST_DISABLE_PLUGIN_AUTOLOAD', '1')
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    ours = ('drake_geom_mutants', 'test_doubling', 'test_elsewhere')
    for name in [name for name in sys.modules if name.startswith(ours)]:
        del sys.modules[name]


def test_the_tests_of_a_file_have_its_path():
    of_model = trials.mirrored(trials.ROOT / 'drake_geom_ros/geometry/model/_model.py')
    assert 'test/geometry/model/test_model.py::test_x'.startswith(of_model)
    assert 'test/geometry/model/test_model_versions.py::test_x'.startswith(of_model)
    assert not 'test/geometry/model/test_models.py::test_x'.startswith(of_model)
    assert trials.mirrored(trials.ROOT / 'drake_geom_ros/a/_b/c.py')[0] == 'test/a/_b/test_c.py::'


def test_the_tests_of_a_line_and_of_what_runs_on_import():
    data = trials.CoverageData(no_disk=True)
    for context, lines in (('', [1, 5]), ('a::one|run', [2]), ('a::two|setup', [2, 6])):
        data.set_context(context)
        data.add_lines({'f.py': lines})
    assert trials.tests_of(data, 'f.py', 2) == {'a::one', 'a::two'}
    assert trials.tests_of(data, 'f.py', 6) == {'a::two'}
    assert trials.tests_of(data, 'f.py', 1) == {'a::one', 'a::two'}
    assert trials.tests_of(data, 'f.py', 3) == set()


MUTANTS = [
    ('x + x', '2 * x', 'survived'),
    ('x + x', 'x - x', 'noticed'),
    ('y < LIMIT', 'y <= LIMIT', 'noticed'),
    ('return LIMIT', 'return 8', 'noticed'),
    ('x + x', 'sys.exit(0)', 'noticed'),
    ('x + x', 'max(iter(int, 1))', 'hung'),
    ('x + x', 'time.sleep(1.0) or 2 * x', 'survived'),  # as on a busy machine
    ('LIMIT = 7', 'LIMIT = 8', 'noticed'),  # what no function holds
    ('LIMIT = 7', 'LIMIT = 7.0', 'survived'),
    ('x + x', 'x +', 'noticed'),
]


def test_a_fault_is_noticed_wherever_it_is_and_nothing_is_left_of_it(tree, monkeypatch):
    monkeypatch.setattr(trials, 'SECONDS_A_TEST', 0.5)
    found = []

    def work(items):
        for before, after, _ in MUTANTS:
            assert before in SOURCE
            code = SOURCE.replace(before, after)
            found.append(trials.end_of(tree / FILE, code, set(), items, 0))

    trials.with_tests_collected(work)
    assert found == [end for _, _, end in MUTANTS]
    assert (tree / FILE).read_text() == SOURCE


def test_only_the_tests_that_matter_run(tree):
    (tree / 'test/test_doubling.py').unlink()
    code = SOURCE.replace('x + x', 'x - x')
    wrong, right = (f'test/test_elsewhere.py::test_{name}' for name in ('double', 'limit'))
    found = []

    def work(items):
        for ids, most in ((set(), 9), ({right}, 9), ({right, wrong}, 9), ({wrong}, 0)):
            found.append(trials.end_of(tree / FILE, code, ids, items, most))

    trials.with_tests_collected(work)
    assert found == ['survived', 'survived', 'noticed', 'survived']
