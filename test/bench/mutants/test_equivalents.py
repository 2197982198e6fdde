import pytest

from bench.mutants import equivalents

WRITTEN = """
a.py:
- why: both are nothing
  mutants: |
    f: if x > 0: ==> if x >= 0:
    f: y = 0 ==> y = -0
- why: never reached
  mutants: |
    g: return 1 ==> return 2
"""


@pytest.fixture
def listed(tmp_path):
    path = tmp_path / 'list.yaml'
    path.write_text(WRITTEN)
    return path


def test_each_mutant_has_its_reason(listed):
    assert equivalents.load(listed) == {
        'a.py': {
            'f: if x > 0: ==> if x >= 0:': 'both are nothing',
            'f: y = 0 ==> y = -0': 'both are nothing',
            'g: return 1 ==> return 2': 'never reached',
        }
    }


def test_a_mutant_is_listed_once(listed):
    listed.write_text(WRITTEN + '    g: return 1 ==> return 2\n')
    with pytest.raises(ValueError, match='twice: g: return 1'):
        equivalents.load(listed)


def test_a_line_is_listed_with_one_change_or_with_all():
    reasons = {'f: x = 1 ==> x = 2': 'why', 'f: y = 1 ==> *': 'why'}
    assert equivalents.is_listed(reasons, 'f: x = 1 ==> x = 2')
    assert not equivalents.is_listed(reasons, 'f: x = 1 ==> x = 3')
    assert equivalents.is_listed(reasons, 'f: y = 1 ==> y = 3')
    assert not equivalents.is_listed(reasons, 'g: y = 1 ==> y = 3')


def test_what_left_the_code_is_stale(listed):
    reasons = equivalents.load(listed)['a.py']
    source = 'def f(x):\n    if x > 0:\n        y = 0\n'
    assert equivalents.stale(reasons, source) == ['g: return 1 ==> return 2']


def test_nothing_is_listed_that_is_not_in_the_code():
    for file, reasons in equivalents.load(equivalents.LIST).items():
        assert equivalents.stale(reasons, (equivalents.ROOT / file).read_text()) == []
        assert all(reasons.values())
