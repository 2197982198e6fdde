"""A loop over cases fails once, and its message holds every case that fails and no other."""

import pytest
from every import check, report


def odd(case):
    assert case % 2, f'{case} is even'


def test_a_loop_without_an_offender_passes():
    report([])
    check(odd, [1, 3])


def test_every_offender_stands_in_the_message_with_its_line_and_the_note():
    with pytest.raises(pytest.fail.Exception) as failed:
        check(odd, [1, *range(2, 80)], lambda case: f'case {case}', 'seed 7')
    heading, *lines = failed.value.msg.splitlines()
    assert heading == '39 wrong (seed 7):'
    named = [line for line in lines if line.startswith('case ')]
    assert [line.split(':')[0] for line in named] == [f'case {k}' for k in range(2, 80, 2)]
    assert all(': test_every.py:8: ' in line and 'is even' in line for line in named)


def test_cases_after_an_error_are_judged_too():
    def judge(case):
        if case == 'raises':
            raise KeyError('gone')
        with pytest.raises(ValueError, match='never'):
            pass

    with pytest.raises(pytest.fail.Exception) as failed:
        check(judge, ['raises', 'misses'])
    assert failed.value.msg.startswith('2 wrong:\nraises: test_every.py:')
    assert "KeyError: 'gone'\nmisses: test_every.py:" in failed.value.msg


def test_a_case_that_cannot_be_judged_here_skips_the_test():
    with pytest.raises(pytest.skip.Exception):
        check(lambda case: pytest.skip('no peer'), [1])
