"""The catalogue of poses that other libraries fail on, as far as closed forms answer them."""

import pytest
from oracles.hard_poses import hard_poses
from oracles.pairs import NAMES, check, evaluate

from drake_geom_ros.geometry._proximity.kernels import boxes, half_spaces, segments, spheres

POSES = hard_poses()


def _kernel(pair):
    name = f'{NAMES[pair.kind_A]}_{NAMES[pair.kind_B]}'
    for module in (spheres, half_spaces, segments, boxes):
        if hasattr(module, name):
            return getattr(module, name)
    return None


CLOSED = [name for name, (pair, _, _) in POSES.items() if _kernel(pair)]


def test_the_catalogue_covers_the_closed_forms():
    assert len(POSES) == 43
    assert len(CLOSED) >= 34


@pytest.mark.parametrize('name', CLOSED)
def test_pose(name):
    pair, distance, tolerance = POSES[name]
    row = check(_kernel(pair), pair)
    assert abs(row.distance - distance) <= tolerance + row.error_bound


@pytest.mark.parametrize('name', CLOSED)
@pytest.mark.parametrize('scale', [1e-6, 1e4])
def test_scaled_pose(name, scale):
    pair, distance, tolerance = POSES[name]
    row = check(_kernel(pair), pair.scaled(scale))
    assert abs(row.distance - scale * distance) <= scale * tolerance + row.error_bound


@pytest.mark.parametrize('name', ['H01', 'H02', 'H10', 'H15', 'H16e', 'H32', 'H33'])
def test_swapped_pose(name):
    pair, _, _ = POSES[name]
    row, swapped = (evaluate(_kernel(p), p) for p in (pair, pair.swapped()))
    assert swapped.distance == pytest.approx(row.distance, abs=row.error_bound)
    if row.unique:
        assert swapped.nhat == pytest.approx(-row.nhat, abs=1e-9)
