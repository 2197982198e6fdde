import csv

import numpy as np
from ros.demo import scenes

from drake_geom_ros.ros.demo.results_csv import COLUMNS, write_results


def test_every_kept_pair_is_a_row_with_its_depth(tmp_path):
    made = scenes.recording()
    rows_written = write_results(made, tmp_path / 'results.csv')
    with open(tmp_path / 'results.csv', newline='') as file:
        reader = csv.DictReader(file)
        assert tuple(reader.fieldnames) == COLUMNS
        rows = list(reader)
    assert len(rows) == rows_written == sum(len(pairs.distance) for pairs in made.pairs)
    deep = [row for row in rows if row['depth']]
    assert [float(row['time']) for row in deep] == [1.0, 1.1, 1.2, 3.0]
    for row in deep:
        assert (row['geometry_a'], row['geometry_b']) == ('left::hand/ball', 'things::can/can')
        assert float(row['depth']) == -float(row['distance']) == 0.002
        assert row['method'] == '2'
    hands = [float(r['distance']) for r in rows if r['geometry_b'] == 'right::hand/ball'
             and r['geometry_a'] == 'left::hand/ball']  # fmt: skip
    np.testing.assert_allclose(hands, 0.3 - 0.005 * np.arange(40))
