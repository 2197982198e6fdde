import tracemalloc
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from numba import config
from oracles.pair_set import PairSet, masks_filter, pairs_between

from drake_geom_ros.geometry._proximity.filters import matrix as filter_matrix
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation
from drake_geom_ros.geometry._proximity.filters.state import FilterState

EXCLUDE_WITHIN, EXCLUDE_BETWEEN, ALLOW_WITHIN, ALLOW_BETWEEN = FilterOperation

WORLD = 1


def make(bodies):
    """Return a state with a geometry for each (key, frame); frame WORLD is anchored."""
    state = FilterState()
    for key, frame in bodies.items():
        state.add(key, frame, frame == WORLD)
    return state


def free(count):
    """Return a state of geometries 1..count, each on a frame of its own."""
    return make({key: 100 + key for key in range(1, count + 1)})


def candidates(state):
    """Return the unordered pairs that ``mask`` lets pass, in either order."""
    keys = np.array(state.all_keys(), dtype=np.int64)
    if keys.size == 0:
        return set()
    slots = state.slots(keys)
    i, j = (side.ravel() for side in np.indices((keys.size, keys.size)))
    passed = state.mask(slots[i], slots[j]).reshape(keys.size, keys.size)
    np.testing.assert_array_equal(passed, passed.T)
    return {frozenset((int(keys[a]), int(keys[b]))) for a, b in np.argwhere(passed)}


def between(a, b):
    return [(EXCLUDE_BETWEEN, tuple(a), tuple(b))]


def allowed(a, b):
    return [(ALLOW_BETWEEN, tuple(a), tuple(b))]


# The invariants.


def test_the_candidates_are_all_pairs_without_anchored_same_frame_and_self():
    state = make({1: WORLD, 2: WORLD, 3: 7, 4: 7, 5: 8})
    expected = {(1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5), (3, 5), (4, 5)}
    assert candidates(state) == {frozenset(pair) for pair in expected}
    assert state.explain(1, 2) == ['anchored']
    assert state.explain(3, 4) == ['same frame']
    assert state.explain(5, 5) == ['self']
    assert state.explain(1, 1) == ['self']
    assert state.filtered_pairs() == 0


def test_allowing_an_invariant_pair_is_ignored():
    state = make({1: WORLD, 2: WORLD, 3: 7, 4: 7})
    before, version = candidates(state), state.version
    state.apply([(ALLOW_WITHIN, (1, 2, 3, 4), ())])
    assert candidates(state) == before
    assert state.version == version
    state.apply([(EXCLUDE_WITHIN, (1, 2, 3, 4), ())])
    assert candidates(state) == set()
    assert state.filtered_pairs() == 4
    state.apply([(ALLOW_WITHIN, (1, 2, 3, 4), ())])
    assert candidates(state) == before
    assert state.filtered_pairs() == 0


def test_slots_are_given_out_from_the_lowest_and_again_and_each_change_is_a_version():
    state, versions = FilterState(), [-1]
    for key in range(70):
        state.add(key, 100 + key, False)
        versions.append(state.version)
    assert state.slots(np.arange(70)).tolist() == list(range(70))
    for key in (3, 68):
        state.remove(key)
        versions.append(state.version)
    assert (np.diff(versions) > 0).all()
    for key in (70, 71):
        state.add(key, 100 + key, False)
    assert state.slots(np.array([70, 71])).tolist() == [68, 3]


# Declarations.


def test_the_worked_table_line_by_line():
    # P1 to P6 are six pairs of twelve geometries; every other pair is taken out of C at first.
    state = free(12)
    pairs = [(1, 2), (3, 4), (5, 6), (7, 8), (9, 10), (11, 12)]
    P = dict(enumerate(pairs, start=1))
    keys = tuple(range(1, 13))
    state.apply([(EXCLUDE_WITHIN, keys, ()), *(s for p in pairs for s in allowed(p[:1], p[1:]))])

    def C():
        return {name for name, pair in P.items() if frozenset(pair) in candidates(state)}

    def said(operation, *names):
        return [(operation, P[name][:1], P[name][1:]) for name in names]

    assert C() == {1, 2, 3, 4, 5, 6}  # 1: initial condition
    state.apply(said(EXCLUDE_BETWEEN, 1))  # 2: remove P1
    assert C() == {2, 3, 4, 5, 6}
    state.apply(said(EXCLUDE_BETWEEN, 6))  # 3: remove Pn
    assert C() == {2, 3, 4, 5}
    state.apply(said(EXCLUDE_BETWEEN, 1, 3, 4, 5, 6))  # 4: remove all except P2
    assert C() == {2}
    state.apply_transient(said(ALLOW_BETWEEN, 4, 5), 1)  # 5: #1 puts P4 and P5 into C
    assert C() == {2, 4, 5}
    state.apply_transient(said(ALLOW_BETWEEN, 3, 4), 2)  # 6: #2 puts P3 and P4 into C
    assert C() == {2, 3, 4, 5}
    assert state.active_ids == [1, 2]
    assert state.remove_declaration(1)  # 7: remove #1; #2 keeps P4
    assert C() == {2, 3, 4}
    assert state.active_ids == [2]
    state.flatten()  # 8: flattened; #2 no longer exists
    assert C() == {2, 3, 4}
    assert not state.has_transient_history
    assert not state.is_active(2)
    assert not state.remove_declaration(2)
    assert C() == {2, 3, 4}
    assert len(candidates(state)) == 3
    state.apply_transient(said(EXCLUDE_BETWEEN, 3, 4), 3)  # the base is what was flattened
    assert C() == {2}
    state.remove_declaration(3)
    assert C() == {2, 3, 4}


def test_order_matters_and_later_statements_win():
    state = free(3)
    exclude, allow = (EXCLUDE_WITHIN, (1, 2), ()), (ALLOW_BETWEEN, (2,), (1,))
    state.apply([exclude, allow])
    assert not state.filtered(1, 2)
    state.apply([allow, exclude])
    assert state.filtered(1, 2)
    state.apply([allow])
    assert not state.filtered(1, 2)


def test_between_overlapping_sets_is_the_cartesian_product():
    state = free(5)
    state.apply(between((1, 2, 3), (3, 4)))
    gone = {(1, 3), (2, 3), (1, 4), (2, 4), (3, 4)}
    every = pairs_between(range(1, 6), range(1, 6))
    assert every - candidates(state) == {frozenset(pair) for pair in gone}


def test_saying_what_holds_already_changes_nothing():
    state = free(4)
    state.apply(between((1, 2), (3,)))
    version, before = state.version, candidates(state)
    state.apply(between((3,), (1,)))
    state.apply_transient(allowed((1,), (2,)), 5)
    state.apply(between((), (1,)))
    assert (state.version, candidates(state)) == (version, before)


def test_a_later_geometry_starts_unfiltered_even_under_a_history():
    state = free(3)
    state.apply([(EXCLUDE_WITHIN, (1, 2, 3), ())])
    state.apply_transient(between((1,), (2, 3)), 1)
    state.add(9, 109, False)
    assert candidates(state) == {frozenset((9, k)) for k in (1, 2, 3)}
    assert state.remove_declaration(1)
    assert candidates(state) == {frozenset((9, k)) for k in (1, 2, 3)}


def test_a_key_that_comes_back_is_a_newcomer():
    state = free(3)
    state.apply([(EXCLUDE_WITHIN, (1, 2, 3), ())])
    state.apply_transient(between((1,), (2,)), 1)
    state.add_group('a', (1,), ('a',))
    state.add_clique('c', (1, 2))
    state.deactivate((1,))
    state.remove(1)
    state.add(1, 101, False)
    assert state.explain(1, 2) == []
    assert candidates(state) == {frozenset((1, 2)), frozenset((1, 3))}
    assert state.groups.membership(1) == 1
    assert state.cliques() == {'c': (2,)}
    assert state.remove_declaration(1)
    assert candidates(state) == {frozenset((1, 2)), frozenset((1, 3))}


def test_what_is_said_of_a_key_that_came_back_is_remembered():
    state = free(3)
    state.apply(between((1,), (3,)))
    state.remove(1)
    state.add(1, 101, False)
    state.apply(between((1,), (2,)))
    state.apply_transient(allowed((1,), (2,)), 1)
    state.remove(3)
    state.apply_transient(allowed((1,), (2,)), 2)
    state.remove_declaration(1)
    assert not state.filtered(1, 2)
    state.remove_declaration(2)
    assert state.explain(1, 2) == ['persistent declaration 1']


# Deactivation.


def test_deactivated_geometry_is_in_no_pair_and_comes_back_as_it_was():
    state = free(4)
    state.apply(between((1,), (2,)))
    before, version = candidates(state), state.version
    state.deactivate((1, 3))
    assert state.version > version
    assert candidates(state) == {frozenset((2, 4))}
    assert state.filtered_pairs() == 5
    assert state.explain(1, 2) == ['deactivated', 'persistent declaration 0']
    state.apply([(ALLOW_WITHIN, (1, 3), ())])
    assert state.explain(1, 3) == ['deactivated']
    version = state.version
    state.deactivate((1,))
    assert state.version == version
    state.activate((1, 3))
    assert candidates(state) == before


def test_invariants_hold_while_deactivated():
    state = make({1: WORLD, 2: WORLD, 3: 7, 4: 7})
    state.deactivate((1, 3))
    assert candidates(state) == {frozenset((2, 4))}
    assert state.filtered_pairs() == 3
    assert state.explain(3, 4) == ['same frame', 'deactivated']
    assert state.explain(1, 2) == ['anchored', 'deactivated']


# Groups and cliques.


def test_the_bit_table_of_the_two_group_example():
    state = free(5)
    state.add_group('groupA', (1, 2), ('groupB',))
    state.add_group('groupB', (3, 4), ('groupA',))
    for key in (1, 2):
        assert (state.groups.membership(key), state.groups.ignore(key)) == (0b0011, 0b0100)
    for key in (3, 4):
        assert (state.groups.membership(key), state.groups.ignore(key)) == (0b0101, 0b0010)
    assert (state.groups.membership(5), state.groups.ignore(5)) == (0b0001, 0b0000)
    every = pairs_between(range(1, 6), range(1, 6))
    assert every - candidates(state) == pairs_between((1, 2), (3, 4))
    assert state.explain(1, 3) == ['group groupA', 'group groupB']


def test_membership_alone_filters_nothing():
    state = free(3)
    state.add_group('a', (1, 2, 3), ())
    assert state.filtered_pairs() == 0


def test_ignoring_a_group_that_does_not_exist_is_fine_until_it_does():
    state = free(3)
    state.add_group('a', (1,), ('later',))
    assert state.filtered_pairs() == 0
    state.add_group('later', (2,), ())
    assert state.explain(1, 2) == ['group a']
    assert state.filtered_pairs() == 1


def test_ignoring_the_universal_group_makes_invisible_also_to_newcomers():
    state = free(4)
    state.add_group('ghosts', (1, 2), ('universal',))
    assert candidates(state) == {frozenset((3, 4))}
    assert state.groups.ignore(1) == 1
    state.add(9, 109, False)
    assert candidates(state) == pairs_between((3, 4, 9), (3, 4, 9))
    assert state.explain(9, 1) == ['group ghosts']
    state.apply(allowed((1,), (3,)))
    assert state.explain(1, 3) == []
    assert state.filtered(1, 4)


def test_the_last_word_counts_between_groups_and_declarations():
    state = free(4)
    state.add_group('a', (1, 2), ('b',))
    state.add_group('b', (3,), ())
    state.apply(allowed((1,), (3,)))
    assert not state.filtered(1, 3)
    assert state.filtered(2, 3)
    state.add_group('b', (4,), ())
    assert state.explain(1, 3) == ['group a']
    assert state.explain(1, 4) == ['group a']


def test_a_group_defined_under_a_history_stays_below_it():
    state = free(4)
    state.apply_transient([*allowed((1,), (2,)), *between((1,), (4,))], 1)
    state.add_clique('c', (1, 2, 3))
    assert candidates(state) == {frozenset(pair) for pair in ((1, 2), (2, 4), (3, 4))}
    state.remove_declaration(1)
    assert candidates(state) == {frozenset((k, 4)) for k in (1, 2, 3)}


def test_three_hundred_groups_agree_with_the_mask_test():
    rng = np.random.default_rng(3)
    state = free(40)
    for group in range(300):
        members = rng.choice(np.arange(1, 41), size=rng.integers(0, 4), replace=False)
        ignored = [f'g{k}' for k in rng.integers(0, 300, size=rng.integers(0, 3))]
        state.add_group(f'g{group}', members.tolist(), ignored)
    masks = {k: (state.groups.membership(k), state.groups.ignore(k)) for k in state.all_keys()}
    assert max(membership for membership, _ in masks.values()) > 2**100
    expected = {
        frozenset((a, b))
        for a, b in combinations(masks, 2)
        if not masks_filter(*masks[a], *masks[b])
    }
    assert 0 < len(expected) < 780
    assert candidates(state) == expected


def test_a_clique_is_a_group_that_ignores_itself():
    members = (2, 3, 5, 7)
    as_clique, as_group, as_pairs = free(8), free(8), free(8)
    as_clique.add_clique('c', members)
    as_group.add_group('c', members, ('c',))
    as_pairs.apply([(EXCLUDE_WITHIN, members, ())])
    assert candidates(as_clique) == candidates(as_group) == candidates(as_pairs)
    assert as_clique.filtered_pairs() == 6
    assert as_clique.explain(2, 7) == ['clique c']


def test_two_groups_that_ignore_each_other_are_as_many_cliques_as_members_of_one():
    # The recipe of the reference page, a clique for each a with all of B, also filters the pairs
    # within B. So it is the same policy where B is one body, and cliques of two are it always.
    group_a, group_b = (1, 2, 3), (4, 5)
    for bodies, within_b in (
        ({1: 11, 2: 12, 3: 13, 4: 20, 5: 20, 6: 30}, set()),
        ({1: 11, 2: 12, 3: 13, 4: 20, 5: 21, 6: 30}, pairs_between(group_b, group_b)),
    ):
        as_groups, as_cliques, as_twos, as_pairs = (make(bodies) for _ in range(4))
        as_groups.add_group('a', group_a, ('b',))
        as_groups.add_group('b', group_b, ('a',))
        as_pairs.apply(between(group_a, group_b))
        for a in group_a:
            as_cliques.add_clique(f'{a}', (a, *group_b))
            for b in group_b:
                as_twos.add_clique(f'{a}-{b}', (a, b))
        policy = candidates(as_pairs)
        assert candidates(as_groups) == candidates(as_twos) == policy
        assert candidates(as_cliques) == policy - within_b


def test_cliques_can_share_members_and_grow():
    state = free(4)
    state.add_clique('first', (1, 2))
    state.add_clique('second', (2, 3))
    assert candidates(state) == {frozenset(p) for p in ((1, 3), (1, 4), (2, 4), (3, 4))}
    state.add_clique('first', (3,))
    assert state.cliques() == {'second': (2, 3), 'first': (1, 2, 3)}
    assert candidates(state) == {frozenset((k, 4)) for k in (1, 2, 3)}
    assert state.explain(2, 3) == ['clique first', 'clique second']


def test_cliques_at_once_are_those_one_after_the_other():
    cliques = [(f'{k}', (k, k + 1)) for k in range(1, 29)]
    cliques += [('large', tuple(range(5, 30))), ('3', (9,)), ('none', ()), ('alone', (30,))]
    for history in ([], [(1, allowed((3, 4, 9), (3, 4, 9))), (2, between((1,), (2, 8)))]):
        at_once, in_turn = free(30), free(30)
        for filter_id, statements in history:
            at_once.apply_transient(statements, filter_id)
        version = at_once.version
        at_once.add_cliques(cliques)
        # Cliques are below what is transient.
        in_turn.apply([(EXCLUDE_WITHIN, m, ()) for _, m in (*cliques, ('3', (3, 4, 9)))])
        for filter_id, statements in history:
            in_turn.apply_transient(statements, filter_id)
        assert at_once.version > version
        assert candidates(at_once) == candidates(in_turn)
        assert at_once.cliques()['3'] == (3, 4, 9)
        assert 'none' not in at_once.cliques()
        at_once.flatten()
        assert candidates(at_once) == candidates(in_turn)


def test_cliques_that_are_there_change_nothing():
    state = free(4)
    state.add_cliques([('a', (1, 2)), ('b', (2, 3))])
    version = state.version
    state.add_cliques([('a', (1, 2)), ('c', (2, 3))])
    assert state.version == version


# Copies, slots, the log.


def test_a_copy_shares_nothing():
    state = free(4)
    state.apply(between((1,), (2,)))
    state.apply_transient(between((3,), (4,)), 1)
    before = candidates(state)
    other = state.copy()
    assert candidates(other) == before
    other.remove_declaration(1)
    other.apply(between((1,), (3, 4)))
    other.add_group('g', (1,), ('universal',))
    other.add_clique('c', (2, 3))
    other.deactivate((2,))
    other.remove(3)
    other.add(7, 107, False)
    assert candidates(state) == before
    assert state.active_ids == [1]
    assert state.groups.names() == []
    assert state.cliques() == {}
    state.remove(1)
    assert 1 in other.all_keys()


def test_slots_stay_while_others_come_and_go():
    state = free(5)
    keys = np.array([2, 5], dtype=np.int64)
    slots = state.slots(keys)
    state.remove(1)
    for key in range(50, 200):
        state.add(key, 300 + key, False)
    np.testing.assert_array_equal(state.slots(keys), slots)
    assert len(set(state.slots(np.array(state.all_keys())).tolist())) == 154


def test_what_is_said_again_does_not_grow_the_log():
    state = free(6)
    for _ in range(1000):
        state.apply([(EXCLUDE_WITHIN, (1, 2), ()), *between((3,), (4, 5))])
        state.apply([(ALLOW_WITHIN, (1, 2), ()), *allowed((4, 5), (3,))])
    assert state.declarations() == [[(ALLOW_WITHIN, (1, 2), ()), *allowed((4, 5), (3,))]]
    assert state.filtered_pairs() == 0


def test_geometry_that_left_does_not_grow_the_log():
    state = free(2)
    for key in range(10, 2010):
        state.add(key, key, False)
        state.apply(between((1,), (key,)))
        state.remove(key)
    assert len(state._log._persistent) < 300
    assert len(state._log._forgotten) < 300
    assert state.declarations() == []


def test_declarations_lead_to_the_same_policy():
    state = free(8)
    state.add_group('a', (1, 2), ('b', 'universal'))
    state.apply([*allowed((1,), (3, 4)), (EXCLUDE_WITHIN, (5, 6, 7), ())])
    state.add_group('b', (3,), ('b',))
    state.add_clique('c', (3, 8))
    state.apply(allowed((5,), (6,)))
    other = free(8)
    for name in state.groups.names():
        other.add_group(name, state.groups.members(name), state.groups.ignored(name))
    for name, members in state.cliques().items():
        other.add_clique(name, members)
    for statements in state.declarations():
        other.apply(statements)
    assert candidates(other) == candidates(state)
    assert state.explain(1, 3) == ['group a']
    other.add(9, 109, False)
    assert other.explain(2, 9) == ['group a']


# Cost.


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason='uncompiled it takes minutes')
def test_five_thousand_geometries_stay_below_ten_megabytes():
    tracemalloc.start()
    state = free(5000)
    keys = tuple(range(1, 5001))
    state.apply([(EXCLUDE_WITHIN, keys, ()), *between(keys[:2500], keys[2500:])])
    state.add_group('a', keys[:1000], ('b',))
    state.add_group('b', keys[1000:2000], ('a',))
    for k in range(0, 5000, 2):
        state.add_clique(f'link {k}', keys[k : k + 2])
    state.apply_transient(allowed(keys[:500], keys[500:1000]), 1)
    used, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert used < 10e6
    assert not state.filtered(1, 501)
    assert state.filtered(1, 1001)


@pytest.fixture
def written(monkeypatch):
    """Count the rows that replays write."""
    count = SimpleNamespace(rows=0)
    write_rows = filter_matrix.write_rows

    def counting(bits, bit_rows, layer, slots, columns, excludes):
        count.rows += len(slots)
        return write_rows(bits, bit_rows, layer, slots, columns, excludes)

    monkeypatch.setattr(filter_matrix, 'write_rows', counting)
    return count


def test_a_removal_replays_only_the_rows_that_it_touched(written):
    state = free(300)
    keys = tuple(range(1, 301))
    state.apply_transient(between(keys[:10], keys[10:20]), 1)
    state.apply_transient(allowed(keys[15:25], keys[100:110]), 2)
    state.apply_transient([(EXCLUDE_WITHIN, keys[100:], ())], 3)
    rows_before = state.matrix[0][filter_matrix.CURRENT].copy()
    written.rows = 0
    state.remove_declaration(1)
    # Of #2 the five rows of geometries 16..20; nothing of #3, whatever its size.
    assert written.rows == 5
    changed = np.flatnonzero((state.matrix[0][filter_matrix.CURRENT] != rows_before).any(axis=1))
    expected = state._bit_rows[state.slots(np.array(keys[:20], dtype=np.int64))]
    np.testing.assert_array_equal(changed, np.sort(expected))


def test_a_removal_looks_at_no_declaration_about_others(monkeypatch):
    state = free(300)
    for filter_id in range(1, 101):
        state.apply_transient(between((filter_id,), (filter_id + 100,)), filter_id)
    state.apply_transient(allowed((7, 200), (107,)), 101)
    looked_at = []
    sides = FilterState._sides
    monkeypatch.setattr(
        FilterState, '_sides', lambda self, entry: looked_at.append(entry) or sides(self, entry)
    )
    for filter_id in (50, 7):
        looked_at.clear()
        state.remove_declaration(filter_id)
        related = {entry.origin.name for entry in looked_at}
        assert related == ({50} if filter_id == 50 else {7, 101})
    assert not state.filtered(50, 150)
    assert not state.filtered(7, 107)
    state.apply_transient(between((7,), (107, 200)), 50)  # the last one, whatever its number
    looked_at.clear()
    state.remove_declaration(100)
    assert [entry.origin.name for entry in looked_at] == [100, 101, 50]
    assert state.filtered(7, 107)
    assert state.filtered(7, 200)


def test_many_that_go_cost_one_pass_over_those_that_stay(written):
    state = free(20)
    for filter_id in range(1, 101):
        state.apply_transient(between((filter_id % 5 + 1,), (10,)), filter_id)
    state.apply_transient(between((1,), (20,)), 101)
    written.rows = 0
    assert state.remove_declarations(range(101)) == list(range(1, 101))
    # Of #101 the one row of a geometry that the others mention.
    assert written.rows == 1
    assert candidates(state) == candidates(free(20)) - {frozenset((1, 20))}
    assert state.active_ids == [101]
    version = state.version
    assert state.remove_declarations([1, 2]) == []
    assert state.version == version


def test_a_declaration_touches_only_the_rows_of_its_sets():
    state = free(300)
    state.apply([(EXCLUDE_WITHIN, tuple(range(1, 301)), ())])
    before = state.matrix[0].copy()
    state.apply(allowed(range(1, 11), range(201, 211)))
    changed = np.flatnonzero((state.matrix[0] != before).any(axis=(0, 2)))
    mentioned = np.array([*range(1, 11), *range(201, 211)], dtype=np.int64)
    rows = state._bit_rows[state.slots(mentioned)]
    np.testing.assert_array_equal(changed, np.sort(rows))


def test_who_has_no_filter_takes_no_memory():
    state = free(30_000)
    assert state.matrix[0].nbytes == 0
    state.apply(allowed((1,), (2, 3)))
    state.apply([(EXCLUDE_WITHIN, (7,), ()), (EXCLUDE_WITHIN, (), ())])
    state.apply_transient(between(range(10, 30), range(100, 120)), 1)
    assert state.matrix[0].nbytes < 130 * 30_000 / 4
    assert state.copy().matrix[0].nbytes == state.matrix[0].nbytes
    assert (state.filtered(10, 100), state.filtered(10, 99)) == (True, False)
    for key in range(10, 30):  # those who come after them take their rows
        state.remove(key)
        state.add(key + 50_000, key + 60_000, False)
    state.apply(between(range(50_010, 50_030), (200,)))
    assert state.matrix[0].nbytes < 130 * 30_000 / 4
    assert state.filtered(50_010, 200)
    assert not state.filtered(50_010, 100)


# Random sequences against plain sets of pairs.

KEYS = st.integers(1, 12)
SETS = st.frozensets(KEYS, max_size=6)
STATEMENTS = st.lists(st.tuples(st.sampled_from(FilterOperation), SETS, SETS), max_size=3)


class AgainstPairSets(RuleBasedStateMachine):
    """Everything that can happen to filters, in any order."""

    def __init__(self):
        super().__init__()
        self.state, self.model, self.next_id = FilterState(), PairSet(), 1

    def known(self, statements):
        """Return the statements about geometries that are there, for both sides."""
        for_state, for_model = [], []
        for operation, a, b in statements:
            a, b = a & self.model.bodies.keys(), b & self.model.bodies.keys()
            b = a if operation in (EXCLUDE_WITHIN, ALLOW_WITHIN) else b
            for_state.append((operation, tuple(sorted(a)), tuple(sorted(b))))
            for_model.append((operation in (EXCLUDE_WITHIN, EXCLUDE_BETWEEN), a, b))
        return for_state, for_model

    @initialize(frames=st.lists(st.integers(WORLD, 8), min_size=8, max_size=8))
    def start(self, frames):
        for key, frame in enumerate(frames, start=1):
            self.add(key, frame)

    @rule(key=KEYS, frame=st.integers(WORLD, 8))
    def add(self, key, frame):
        if key not in self.model.bodies:
            self.state.add(key, frame, frame == WORLD)
            self.model.bodies[key] = frame

    @rule(key=KEYS)
    def remove(self, key):
        if key in self.model.bodies:
            self.state.remove(key)
            self.model.remove(key)

    @precondition(lambda self: not self.model.history)
    @rule(statements=STATEMENTS)
    def apply(self, statements):
        for_state, for_model = self.known(statements)
        self.state.apply(for_state)
        self.model.apply(for_model)

    @rule(statements=STATEMENTS)
    def apply_transient(self, statements):
        for_state, for_model = self.known(statements)
        self.state.apply_transient(for_state, self.next_id)
        self.model.history[self.next_id] = for_model
        self.next_id += 1

    @rule(age=st.integers(1, 4))
    def remove_declaration(self, age):
        existed = self.model.history.pop(self.next_id - age, None) is not None
        assert self.state.remove_declaration(self.next_id - age) == existed

    @rule(ages=st.lists(st.integers(1, 4)))
    def remove_declarations(self, ages):
        gone = {i for age in ages if (i := self.next_id - age) in self.model.history}
        for filter_id in gone:
            del self.model.history[filter_id]
        assert set(self.state.remove_declarations(self.next_id - age for age in ages)) == gone

    @rule()
    def flatten(self):
        self.state.flatten()
        self.model.flatten()

    @rule(members=SETS, name=st.sampled_from('ab'))
    def clique(self, members, name):
        members = members & self.model.bodies.keys()
        joined = members | set(self.state.cliques().get(name, ()))
        self.state.add_clique(name, members)
        self.model.apply([(True, joined, joined)])

    @rule(keys=SETS, active=st.booleans())
    def switch(self, keys, active):
        keys = keys & self.model.bodies.keys()
        (self.state.activate if active else self.state.deactivate)(keys)
        self.model.off = self.model.off - keys if active else self.model.off | keys

    @rule()
    def copy(self):
        self.state = self.state.copy()

    @invariant()
    def agrees(self):
        expected = self.model.candidates()
        assert candidates(self.state) == expected
        assert self.state.active_ids == list(self.model.history)
        assert self.state.filtered_pairs() == len(self.model.possible() - expected)
        for a, b in combinations(self.model.bodies, 2):
            filtered = frozenset((a, b)) not in expected
            assert self.state.filtered(a, b) == filtered
            assert bool(self.state.explain(a, b)) == filtered


AgainstPairSets.TestCase.settings = settings(
    max_examples=50, stateful_step_count=30, derandomize=True
)
TestAgainstPairSets = AgainstPairSets.TestCase
