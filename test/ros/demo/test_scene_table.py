import numpy as np
from ros.demo import scenes


def test_names():
    table = scenes.table()
    assert table[1].full_name == 'left::hand/ball'
    assert table[1].body == 'left::hand'
    assert table[5].full_name == 'room::world/table'
    assert table[5].body == 'room::table'
    assert table.pair_name(1, 5) == 'left::hand - room::table'


def test_pairs_between_two_sources_in_either_order():
    id_a, id_b = np.array([1, 3, 1, 1, 3]), np.array([3, 2, 2, 5, 4])
    mask = scenes.table().between(id_a, id_b, ('right', 'left'))
    assert mask.tolist() == [True, True, False, False, False]
