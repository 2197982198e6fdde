"""The list of cases is complete, and is chosen from by name."""

from bench.accuracy.cases import all_cases
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
