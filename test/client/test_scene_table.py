"""Names and frames of a scene, from its message."""

import numpy as np
import pytest
from ros.demo import scenes
from ros.demo.test_reading import SCENE

from drake_geom_ros.client.scene_table import SceneTable


def test_names():
    table = scenes.table()
    assert table[1].full_name == 'left::hand/ball'
    assert table[1].body == 'left::hand'
    assert table[5].full_name == 'room::world/table'
    assert table[5].body == 'room::table'
    assert table.pair_name(1, 5) == 'left::hand - room::table'


def test_a_message_gives_names_shapes_poses_and_parents():
    table = SceneTable.from_message(SCENE)
    assert table.version == 7
    assert table[5].full_name == 'room::world/table'
    assert table[5].anchored
    assert (table[6].full_name, table[6].frame) == ('arm::tip/ball', 'arm::tip')
    assert (table[6].shape_type, table[6].dimensions) == (1, (0.1,))
    np.testing.assert_allclose(table[6].X_FG[:3, 3], [0, 0, 0.2])
    assert list(table.parents.items()) == [('arm::hand', 'world'), ('arm::tip', 'arm::hand')]


def test_pairs_between_two_sources_in_either_order():
    id_a, id_b = np.array([1, 3, 1, 1, 3]), np.array([3, 2, 2, 5, 4])
    mask = scenes.table().between(id_a, id_b, ('right', 'left'))
    assert mask.tolist() == [True, True, False, False, False]


@pytest.mark.parametrize(
    ('pattern', 'ids'),
    [
        ('left', [1, 2]),
        ('left::hand', [1]),
        ('hand', [1, 3]),
        ('hand/ball', [1, 3]),
        ('right::hand/ball', [3]),
        ('*::hand/*', [1, 3]),
        ('ball', [1, 3]),
        ('room', [5, 6, 7]),
        ('room::table', [5]),
        ('world/table', [5]),
        ('*', [1, 2, 3, 4, 5, 6, 7]),
        ('nobody', []),
    ],
)
def test_what_a_name_or_a_pattern_stands_for(pattern, ids):
    assert scenes.table().ids(pattern).tolist() == ids
