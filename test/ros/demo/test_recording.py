import numpy as np
import pytest
from ros.demo import demo_scenes as scenes

from drake_geom_ros.ros.demo import recording as module
from drake_geom_ros.ros.demo.recording import Recording, percentiles


def _add(made, time, ids, distance):
    ids = np.array(ids)
    count = len(distance)
    made.add_distances(
        time, 0.001, ids[:, 0], ids[:, 1], np.array(distance), np.zeros(count), np.ones(count)
    )


def test_the_closest_geometries_of_each_two_things_closest_first():
    made = Recording(scenes.table())
    # 2 - 3 and 1 - 3 are different things; 1 - 3 twice would be the same.
    _add(made, 5.0, [(1, 3), (2, 3), (1, 3), (4, 5)], [0.3, 0.2, 0.1, -0.01])
    kept = made.pairs[0]
    assert kept.distance.tolist() == [-0.01, 0.1, 0.2]
    assert list(zip(kept.id_a, kept.id_b, strict=True)) == [(4, 5), (1, 3), (2, 3)]
    assert made.start == 5.0


def test_the_distance_between_the_robots_is_kept_apart():
    made = Recording(scenes.table(), ('left', 'right'))
    _add(made, 0.0, [(1, 3), (2, 3), (4, 5)], [0.3, 0.2, -0.01])
    _add(made, 1.0, [(4, 5)], [-0.01])
    assert [pairs.between for pairs in made.pairs] == [0.2, np.inf]


def test_closer_names_each_new_closest_pair_of_the_robots_once():
    made = Recording(scenes.table(), ('left', 'right'))
    ids = np.array([1, 2, 4]), np.array([3, 3, 5])
    assert made.closer(*ids, np.array([0.3, 0.2, -0.01])) == 1
    assert made.closer(*ids, np.array([0.3, 0.2, -0.01])) is None
    assert made.closer(*ids, np.array([0.1, 0.2, -0.01])) == 0
    assert made.closer(np.array([4]), np.array([5]), np.array([-1.0])) is None


def test_one_robot_is_not_pictured_with_itself():
    made = Recording(scenes.table(), ('left',))
    ids = np.array([1, 1, 2]), np.array([2, 3, 3])
    assert made.closer(*ids, np.array([-0.1, 0.3, 0.2])) == 2


def test_without_robots_every_pair_counts():
    made = Recording(scenes.table())
    assert made.closer(np.array([4]), np.array([5]), np.array([-0.01])) == 0
    assert made.closer(np.array([]), np.array([]), np.array([])) is None


def test_the_deepest_contact_and_every_depth_are_kept():
    made = Recording(scenes.table())
    made.add_penetrations(1.0, np.array([1, 4]), np.array([4, 5]), np.array([0.001, 0.003]))
    made.add_penetrations(2.0, np.array([], int), np.array([], int), np.array([]))
    assert [(c.time, c.depth, c.id_a, c.id_b) for c in made.contacts] == [
        (1.0, 0.003, 4, 5),
        (2.0, 0.0, 0, 0),
    ]
    assert made.depth_of == {(1.0, 1, 4): 0.001, (1.0, 4, 5): 0.003}


def test_a_long_recording_forgets_its_older_half(monkeypatch):
    monkeypatch.setattr(module, 'RESULTS_KEPT', 10)
    made = Recording(scenes.table())
    for k in range(25):
        _add(made, float(k), [(4, 5)], [-0.01])
        made.add_penetrations(float(k), np.array([4]), np.array([5]), np.array([0.01]))
        made.cycle_seconds.append(0.001)
    assert len(made.pairs) <= 10
    assert made.start == 0.0
    assert made.pairs[-1].time == made.contacts[-1].time == 24.0
    oldest = made.pairs[0].time
    assert min(c.time for c in made.contacts) == oldest == min(k[0] for k in made.depth_of)


def test_percentiles():
    p50, p99 = percentiles([float(k) for k in range(101)])
    assert (p50, p99) == pytest.approx((50.0, 99.0))
    assert np.isnan(percentiles([])).all()
