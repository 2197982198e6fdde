from collections import Counter

import pytest

pytest.importorskip('cosmic_ray', reason='./run mutants installs it')
from bench.mutants.mutations import mutants_of, sample

CODE = '''"""Half 1."""
LIMIT: int | None = 7


@decorated(2)
def half(x: float | None = 1) -> int | str:
    """Return 3."""
    if x < LIMIT and not x:
        return x / 2
    for k in range(x):
        continue
    return -x
'''


@pytest.fixture
def file(tmp_path):
    path = tmp_path / 'half.py'
    path.write_text(CODE)
    return path


def test_what_computes_is_changed_and_nothing_else(file):
    mutants = mutants_of(file)
    assert {mutant.line for mutant in mutants} == {2, 6, 8, 9, 10, 11, 12}
    assert {mutant.says(mutant.code()) for mutant in mutants} == {
        'module: LIMIT: int | None = 7 ==> LIMIT: int | None = 8',
        'module: LIMIT: int | None = 7 ==> LIMIT: int | None = 6',
        'half: def half(x: float | None = 1) -> int | str: '
        '==> def half(x: float | None = 2) -> int | str:',
        'half: def half(x: float | None = 1) -> int | str: '
        '==> def half(x: float | None = 0) -> int | str:',
        'half: if x < LIMIT and not x: ==> if x <= LIMIT and not x:',
        'half: if x < LIMIT and not x: ==> if x >= LIMIT and not x:',
        'half: if x < LIMIT and not x: ==> if x < LIMIT or not x:',
        'half: if x < LIMIT and not x: ==> if x < LIMIT and  x:',
        'half: return x / 2 ==> return x * 2',
        'half: return x / 2 ==> return x / 3',
        'half: return x / 2 ==> return x / 1',
        'half: for k in range(x): ==> for k in []:',
        'half: continue ==> break',
        'half: return -x ==> return x',
    }


def test_a_mutant_differs_in_one_line(file):
    for mutant in mutants_of(file):
        changed = [
            k
            for k, (old, new) in enumerate(
                zip(CODE.splitlines(), mutant.code().splitlines(), strict=True), start=1
            )
            if old != new
        ]
        assert changed == [mutant.line]


def test_a_sample_is_the_same_for_a_seed_and_holds_all_kinds_alike(file):
    mutants = mutants_of(file)
    chosen = sample(mutants, 6, seed=1)
    assert chosen == sample(mutants, 6, seed=1)
    assert Counter(mutant.kind for mutant in chosen) == {
        'comparisons': 2,
        'operators': 2,
        'constants': 2,
    }
    assert set(sample(mutants, 100, seed=2)) == set(mutants)
