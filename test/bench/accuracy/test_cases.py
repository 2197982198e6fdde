"""The list of cases is complete, and is chosen from by name."""

import pytest

from bench.accuracy.cases import all_cases, chosen, round_robin
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.geometry._proximity.kernels.pair_table import PAIR_TABLE, SHAPE_NAMES
from truth.judging.asking import POINTS


def test_every_row_of_the_pair_table_is_a_case():
    rows = {(SHAPE_NAMES[row.type_a], SHAPE_NAMES[row.type_b]) for row in PAIR_TABLE}
    cases = all_cases()
    assert {(case.a, case.b) for case in cases} >= rows
    assert {case.b for case in cases if case.queries == (POINTS,)} == set(SHAPE_NAMES.values()) - {
        'Mesh',
        *('OccupiedCells', 'PointCloud'),
    }
    names = [case.name for case in cases]
    assert len(set(names)) == len(names)


def test_names_and_patterns_choose():
    found = chosen(all_cases(), ['Box-C*', 'Point-Sphere'])
    assert {case.name for case in found} == {
        'Box-Capsule', 'Box-Cylinder', 'Box-Convex8', 'Box-Convex64', 'Box-Convex500',
        'Point-Sphere',
    }  # fmt: skip
    assert chosen(all_cases(), []) == all_cases()


def test_an_unknown_name_is_refused_with_the_names_that_are_there():
    with pytest.raises(ArgumentError, match=r'--cases Cone-\*.*Box-Box'):
        chosen(all_cases(), ['Cone-*'])


def test_families_take_turns():
    cases = all_cases()
    ordered = round_robin(cases)
    families = list(dict.fromkeys(case.family for case in cases))
    assert [case.family for case in ordered[: len(families)]] == families
    assert sorted(map(str, ordered)) == sorted(map(str, cases))
