import pytest

from drake_geom_ros.geometry._proximity.filters.groups import UNIVERSAL, FilterGroups


def test_all_belong_to_the_universal_group_and_ignore_nothing_at_first():
    groups = FilterGroups()
    assert (groups.membership(7), groups.ignore(7)) == (1, 0)
    assert groups.names() == []


def test_groups_take_bits_as_they_are_named_be_it_as_ignored():
    groups = FilterGroups()
    groups.define('a', (1,), ('c', UNIVERSAL))
    groups.define('b', (2,), ())
    groups.define('c', (3, 1), ('a',))
    assert groups.membership(1) == 0b0111
    assert groups.ignore(1) == 0b0111
    assert (groups.membership(2), groups.ignore(2)) == (0b1001, 0)
    assert (groups.membership(3), groups.ignore(3)) == (0b0101, 0b0010)
    assert groups.names() == ['a', 'b', 'c']
    assert groups.ignored('a') == [UNIVERSAL, 'c']
    assert groups.members('c') == (1, 3)


def test_defining_again_adds():
    groups = FilterGroups()
    groups.define('a', (1,), ('b',))
    groups.define('a', (2,), ('c',))
    assert groups.members('a') == (1, 2)
    assert groups.ignored('a') == ['b', 'c']
    assert groups.ignore(1) == groups.ignore(2) == 0b1100


def test_relations_in_both_directions():
    groups = FilterGroups()
    groups.define('a', (1,), ('b', 'a'))
    groups.define('b', (2,), ())
    assert sorted(groups.relations('a')) == [('a', 'a'), ('a', 'b')]
    assert sorted(groups.relations('b')) == [('a', 'b')]
    assert groups.ignoring('b') == ['a']
    assert groups.ignoring(UNIVERSAL) == []


@pytest.mark.parametrize('count', [62, 63, 64, 65, 500])
def test_any_number_of_groups(count):
    groups = FilterGroups()
    for k in range(count):
        groups.define(f'g{k}', (k,), (f'g{k - 1}',) if k else ())
    assert groups.membership(count - 1) == 1 | 1 << count
    assert groups.ignore(count - 1) == 1 << (count - 1)


def test_forgetting_and_copying():
    groups = FilterGroups()
    groups.define('a', (1, 2), ('a',))
    other = groups.copy()
    groups.forget(1)
    groups.define('b', (2,), ())
    assert groups.members('a') == (2,)
    assert other.members('a') == (1, 2)
    assert other.names() == ['a']
    assert (groups.membership(1), groups.ignore(1)) == (1, 0)
