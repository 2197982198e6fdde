from drake_geom_ros.geometry._proximity.filters.log import (
    FilterLog,
    FilterOperation,
    clique,
    group_relation,
)

EXCLUDE_WITHIN, EXCLUDE_BETWEEN, ALLOW_WITHIN, ALLOW_BETWEEN = FilterOperation

EVERYTHING = (1, 2, 3, 4, 5)


def test_reasons_go_back_to_the_last_allowance_newest_first():
    log = FilterLog()
    log.declare([(EXCLUDE_WITHIN, (1, 2, 3), ())])
    log.declare([(ALLOW_BETWEEN, (1,), (2,))])
    log.relate(clique('c', (1, 2)))
    log.relate(group_relation('g', (2,), 'universal', None))
    log.push(8, [(EXCLUDE_BETWEEN, (2,), (1, 3))])
    assert log.reasons(1, 2) == ['transient declaration 8', 'group g', 'clique c']
    assert log.reasons(3, 2) == ['transient declaration 8', 'group g', 'persistent declaration 0']
    assert log.reasons(1, 3) == ['persistent declaration 0']
    log.push(9, [(ALLOW_WITHIN, (1, 2), ())])
    assert log.reasons(2, 1) == []
    log.pull(9)
    log.flatten()
    assert log.reasons(1, 2) == ['persistent declaration 2', 'group g', 'clique c']
    log.declare([(EXCLUDE_WITHIN, (4, 5), ())])
    assert log.reasons(4, 5) == ['persistent declaration 3']


def test_a_statement_takes_the_place_of_one_about_the_same_sets():
    log = FilterLog()
    log.declare([(EXCLUDE_BETWEEN, (1, 2), (3,))])
    log.declare([(EXCLUDE_WITHIN, (4, 5), ())])
    log.declare([(ALLOW_BETWEEN, (3,), (1, 2))])
    assert log.declarations(EVERYTHING) == [
        [(EXCLUDE_WITHIN, (4, 5), ())],
        [(ALLOW_BETWEEN, (3,), (1, 2))],
    ]
    assert log.reasons(4, 5) == ['persistent declaration 1']


def test_a_relation_and_a_declaration_about_the_same_sets_are_two_reasons():
    log = FilterLog()
    log.relate(clique('c', (1, 2)))
    log.declare([(EXCLUDE_WITHIN, (1, 2), ())])
    assert log.reasons(1, 2) == ['persistent declaration 0', 'clique c']


def test_statements_about_no_pairs_leave_no_entry_but_count_as_a_declaration():
    log = FilterLog()
    assert log.declare([(EXCLUDE_BETWEEN, (1,), ()), (EXCLUDE_WITHIN, (), ())]) == []
    log.declare([(EXCLUDE_WITHIN, (1, 2), ())])
    assert log.reasons(1, 2) == ['persistent declaration 1']


def test_relations_after_a_declaration_are_repeated_as_declarations():
    log = FilterLog()
    log.relate(clique('early', (1, 2)))
    log.declare([(ALLOW_WITHIN, (1, 2), ())])
    log.relate(clique('late', (2, 3)))
    log.relate(group_relation('ghosts', (4,), 'universal', None))
    assert log.declarations(EVERYTHING) == [
        [(ALLOW_WITHIN, (1, 2), ())],
        [(EXCLUDE_WITHIN, (2, 3), ())],
        [(EXCLUDE_BETWEEN, (4,), EVERYTHING)],
    ]


def test_what_leaves_is_struck_and_does_not_mean_a_newcomer():
    log = FilterLog()
    log.declare([(EXCLUDE_WITHIN, (1, 2, 3), ()), (EXCLUDE_BETWEEN, (1,), (4,))])
    log.push(5, [(EXCLUDE_BETWEEN, (1,), (2,)), (ALLOW_BETWEEN, (1, 2), (3,))])
    log.relate(group_relation('ghosts', (2,), 'universal', None))
    log.forget(1)
    log.register(1)
    log.declare([(EXCLUDE_WITHIN, (1, 5), ())])
    assert log.reasons(1, 5) == ['persistent declaration 1']
    assert log.reasons(1, 2) == ['group ghosts']
    assert log.reasons(1, 3) == []
    assert [entry.statement(EVERYTHING) for entry in log.history()] == [
        (ALLOW_BETWEEN, (2,), (3,))
    ]
    assert log.declarations(())[0] == [(EXCLUDE_WITHIN, (2, 3), ())]
    assert log.active_ids() == [5]
