"""Who does not renew a lease loses the filter."""

import pytest

from drake_geom_ros.geometry import FilterId
from drake_geom_ros.live.scene.leases import Leases


@pytest.fixture
def leases(clock):
    return Leases(clock)


def test_a_lease_ends_once(leases, clock):
    short, long = FilterId.get_new_id(), FilterId.get_new_id()
    leases.grant(short, 1.0)
    leases.grant(long, 2.0)
    clock.now += 0.9
    assert leases.take_expired() == []
    clock.now += 0.1
    assert leases.take_expired() == [short]
    assert leases.take_expired() == []
    clock.now += 1.0
    assert leases.take_expired() == [long]


def test_a_lease_that_is_renewed_ends_later_and_one_of_0_never(leases, clock):
    renewed, freed = FilterId.get_new_id(), FilterId.get_new_id()
    for filter_id in (renewed, freed):
        leases.grant(filter_id, 1.0)
    clock.now += 0.9
    leases.grant(renewed, 1.0)
    leases.grant(freed, 0.0)
    clock.now += 0.9
    assert leases.take_expired() == []
    clock.now += 1e6
    assert leases.take_expired() == [renewed]


def test_nothing_is_known_of_a_filter_without_a_lease(leases):
    leases.grant(FilterId.get_new_id(), 0.0)
    assert leases.take_expired() == []
