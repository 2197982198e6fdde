"""Collision filters of a node in its own process, through real services."""

import pytest
from drake_geom_msgs import msg, srv
from ros.scene_calls import (
    accepted,
    add_pair,
    declaration,
    exclude,
    poses,
    refused,
)
from std_srvs.srv import Trigger

pytestmark = pytest.mark.topics

PAIR = ['a', 'b']


def test_filters_through_services(client):
    small, large = add_pair(client, 'filters')
    names = ['filters::a/ball', 'filters::b/ball']
    together = poses(PAIR, [(0, 0, 0), (0, 0, 0)], 'filters')

    def reported():
        answer = client.call(
            srv.ComputePointPairPenetration, 'compute_point_pair_penetration', poses=together
        )
        result = accepted(answer).result
        return (small, large) in zip(result.id_a, result.id_b, strict=True)

    def explain():
        answer = client.call(
            srv.ExplainFilter, 'explain_filter', geometry_a=names[0], geometry_b=names[1]
        )
        return accepted(answer).reasons

    assert reported()
    transient = accepted(
        client.call(
            srv.ApplyTransientFilter, 'apply_transient_filter', declaration=exclude(*names)
        )
    )
    assert not reported()
    assert any(str(transient.filter_id) in reason for reason in explain())
    refused(client.call(srv.ApplyFilter, 'apply_filter', declaration=exclude(*names)), 'transient')
    state = accepted(client.call(srv.GetFilters, 'get_filters'))
    assert state.has_transient_history
    assert list(state.active_filter_ids) == [transient.filter_id]
    assert state.filtered_pairs == 1
    removal = {'filter_id': transient.filter_id}
    assert accepted(client.call(srv.RemoveFilter, 'remove_filter', **removal)).removed
    assert not accepted(client.call(srv.RemoveFilter, 'remove_filter', **removal)).removed
    assert reported()
    accepted(client.call(srv.ApplyFilter, 'apply_filter', declaration=exclude(*names)))
    assert not reported()
    allow = declaration(msg.CollisionFilterStatement.ALLOW_BETWEEN, names[:1], names[1:])
    accepted(client.call(srv.ApplyTransientFilter, 'apply_transient_filter', declaration=allow))
    assert reported()
    accepted(client.call(Trigger, 'flatten_filters'))
    assert reported()
    assert not accepted(client.call(srv.GetFilters, 'get_filters')).has_transient_history


def test_a_lease_ends_unless_renewed(client):
    add_pair(client, 'lease')
    names = ['lease::a/ball', 'lease::b/ball']
    apply = {'declaration': exclude(*names), 'owner': 'test'}

    def leased():
        request = {'lease': 0.3, **apply}
        answer = client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **request)
        return accepted(answer).filter_id

    def renewed():
        """Return a filter that was renewed; None where a busy machine took too long."""
        request = {'filter_id': leased(), 'lease': 600.0}
        answer = accepted(client.call(srv.RenewFilter, 'renew_filter', **request))
        return request['filter_id'] if answer.active else None

    kept = client.wait_for(renewed, 'a filter that is renewed in time')
    lost = leased()  # whose lease ends after the first one of the other

    def active():
        return list(accepted(client.call(srv.GetFilters, 'get_filters')).active_filter_ids)

    client.wait_for(lambda: lost not in active(), 'the lease to run out')
    assert kept in active()
    assert not accepted(
        client.call(srv.RenewFilter, 'renew_filter', filter_id=lost, lease=1.0)
    ).active
    refused(client.call(srv.RenewFilter, 'renew_filter', filter_id=kept, lease=-1.0), 'lease')
    accepted(client.call(srv.RemoveFilter, 'remove_filter', filter_id=kept))
