"""The owner of a transient filter dies: the filter lives on while it was renewed, then goes."""

import signal
import subprocess
import sys

import pytest
from drake_geom_msgs import srv
from ros.harness import environment, start_node
from ros.scene_calls import accepted, add_pair, exclude, refused

pytestmark = pytest.mark.topics

LEASE = 3.0  # [s] much longer than a busy machine needs for a call
MANY = 50  # transient filters that an owner may have
PAIR = {'geometry_a': 's::a/ball', 'geometry_b': 's::b/ball'}
# Applies a filter with a lease, and renews it often, so that a busy machine may delay some.
OWNER = f"""
import time
from drake_geom_msgs import srv
from ros.harness import Client
from ros.scene_calls import exclude
client = Client()
pair = exclude('s::a/ball', 's::b/ball')
answer = client.call(srv.ApplyTransientFilter, 'apply_transient_filter', declaration=pair,
                     lease={LEASE}, owner='owner')
print(answer.filter_id, flush=True)
while True:
    time.sleep({LEASE / 12})
    renewed = client.call(srv.RenewFilter, 'renew_filter', filter_id=answer.filter_id,
                          lease={LEASE})
    print(renewed.active, flush=True)
"""


@pytest.fixture
def node(tmp_path):
    process = start_node(tmp_path / 'log', filters_per_owner=MANY)
    yield process
    assert process.end() == 0, process.output()


@pytest.fixture
def owner(client):
    add_pair(client, 's')
    env = environment()
    env['PYTHONPATH'] += ':test'
    process = subprocess.Popen(
        [sys.executable, '-c', OWNER], env=env, stdout=subprocess.PIPE, text=True
    )
    yield process
    process.kill()
    process.communicate()


def test_a_filter_outlives_its_owner_by_its_lease(node, owner, client):
    def reasons():
        return list(accepted(client.call(srv.ExplainFilter, 'explain_filter', **PAIR)).reasons)

    number = int(owner.stdout.readline())
    # Renewed, it outlives its lease three times over.
    for _ in range(36):
        assert owner.stdout.readline() == 'True\n'
    assert reasons() == [f"transient declaration {number} (owner 'owner')"]
    # Meanwhile the persistent layer cannot change.
    apply = {'declaration': exclude(*PAIR.values())}
    refused(client.call(srv.ApplyFilter, 'apply_filter', **apply), 'transient')
    owner.send_signal(signal.SIGKILL)
    client.wait_for(lambda: not reasons(), 'the filter to vanish')
    line = f"the lease of transient filter {number} expired: removed (owner 'owner')"
    client.wait_for(lambda: line in node.output(), 'the reason in the log')
    renewal = client.call(srv.RenewFilter, 'renew_filter', filter_id=number, lease=LEASE)
    assert not accepted(renewal).active
    assert reasons() == []
    accepted(client.call(srv.ApplyFilter, 'apply_filter', **apply))
    assert reasons() == ['persistent declaration 0']


def test_what_one_owner_may_have_is_limited_and_goes_with_its_leases(client):
    add_pair(client, 's')
    declaration = exclude(*PAIR.values())

    def ask(owner):
        fields = {'declaration': declaration, 'owner': owner}
        return client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **fields)

    def active():
        return list(accepted(client.call(srv.GetFilters, 'get_filters')).active_filter_ids)

    numbers = [accepted(ask('hoarder')).filter_id for _ in range(MANY)]
    refused(ask('hoarder'), f"owner 'hoarder' has {MANY} transient filters")
    other = accepted(ask('other')).filter_id
    assert active() == [*numbers, other]
    for number in numbers:
        accepted(client.call(srv.RenewFilter, 'renew_filter', filter_id=number, lease=0.1))
    client.wait_for(lambda: active() == [other], 'the leases to end')
    accepted(ask('hoarder'))
