"""Which places rays go past, against each ray and each place one by one."""

import numpy as np
import pytest

from drake_geom_ros.sensed_maps.looking_past import rays_past


def one_by_one(ends, places, width, noise):
    counts = np.zeros(len(places), dtype=int)
    finite = ends[np.isfinite(ends).all(axis=1) & ends.any(axis=1)].astype(float)
    lengths = np.linalg.norm(finite, axis=1)
    for k, place in enumerate(places):
        away = np.linalg.norm(place)
        if not away:
            continue
        off = np.linalg.norm(finite / lengths[:, np.newaxis] - place / away, axis=1)
        counts[k] = ((off <= min(width / away, 0.2)) & (lengths > away + noise)).sum()
    return counts


def columns(ends):
    return tuple(ends.T[:, np.newaxis])


@pytest.mark.parametrize('kind', [np.float32, np.float64])
@pytest.mark.parametrize('spread', [0.05, 0.5, 3.0])
def test_the_rays_past_a_place_are_those_of_all_one_by_one(spread, kind):
    rng = np.random.default_rng(7)
    axis = rng.normal(size=3)
    ends = (axis + spread * rng.normal(size=(3000, 3))) * rng.uniform(0.1, 4.0, (3000, 1))
    ends[::50] = np.nan
    ends[1::50, 1] = np.inf
    ends[2] = 0.0
    places = (axis + spread * rng.normal(size=(60, 3))) * rng.uniform(0.1, 4.0, (60, 1))
    places[0] = 0.0
    ends = ends.astype(kind)
    found = rays_past(columns(ends), places, 0.05, 0.01)
    assert found.tolist() == one_by_one(ends, places, 0.05, 0.01).tolist()
    assert found[0] == 0
    assert 5 < (found > 0).sum() < 60


def test_a_ray_that_ends_at_the_place_or_within_the_noise_behind_it_is_not_past_it():
    place = np.array([[0.0, 0.0, 1.0]])
    for length, past in ((0.99, 0), (1.0, 0), (1.009, 0), (1.011, 1), (5.0, 1)):
        assert rays_past(columns(length * place), place, 0.01, 0.01).tolist() == [past]
    beside = np.array([[0.0101, 0.0, 1.0]])
    assert rays_past(columns(3.0 * beside), place, 0.01, 0.01).tolist() == [0]


def test_no_places_and_no_rays_are_none():
    nothing = np.zeros((0, 3))
    assert rays_past(columns(np.ones((4, 3))), nothing, 0.01, 0.01).tolist() == []
    assert rays_past(columns(nothing), np.ones((2, 3)), 0.01, 0.01).tolist() == [0, 0]
