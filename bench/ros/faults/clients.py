"""Faults of those who ask and listen: too many at once, killed, stopped, forgetful."""

from __future__ import annotations

import signal
from typing import Any

from drake_geom_msgs import msg, srv

from bench.ros.faults.site import Site

CALLS = 200  # of a burst
LEASES, AT_ONCE = 1000, 250
LEASE = 0.5  # [s]
DYING, POINTS = 4, 1500  # clients, and points that they ask about: 12 MB with two arms
LIFE = 0.5  # [s] of a client that dies, at most


def burst(site: Site) -> str:
    """Call two hundred times at once."""
    client = site.client(srv.HasCollisions, f'{site.server}/has_collisions')
    futures = [client.call_async(srv.HasCollisions.Request()) for _ in range(CALLS)]
    site.wait_for(lambda: all(f.done() for f in futures), f'{CALLS} answers')
    return ''


def killed_clients(site: Site) -> str:
    """Kill clients while they wait for large answers or read them."""
    dying = site.processes.start(
        'bench.ros.dying',
        *('--clients', str(DYING), '--seed', str(site.random.randrange(10**6))),
        *('--points', str(POINTS), '--life', str(LIFE)),
    )
    site.wait_for(lambda: dying.poll() is not None, 'the clients to die')
    site.processes.forget(dying)
    return site.trouble()


def stopped_subscriber(site: Site) -> str:
    """Stop a subscriber that reads, and kill it later."""
    listener = site.processes.start('bench.ros.listener')
    site.spin(site.random.uniform(0.5, 1.5))
    listener.send_signal(signal.SIGSTOP)
    site.spin(site.random.uniform(0.5, 1.5))
    listener.kill()
    site.processes.forget(listener)
    return site.trouble()


def leases(site: Site) -> str:
    """Take a thousand leases, which run out almost together."""
    client = site.client(srv.ApplyTransientFilter, f'{site.server}/apply_transient_filter')
    request = srv.ApplyTransientFilter.Request(
        declaration=msg.CollisionFilterDeclaration(), lease=LEASE, owner='leases'
    )
    futures: list[Any] = []

    def all_done() -> bool:
        return all(future.done() for future in futures)

    while len(futures) < LEASES:
        futures += [client.call_async(request) for _ in range(AT_ONCE)]
        site.wait_for(all_done, f'{len(futures)} leases')
    mine = {f.result().filter_id for f in futures if f.result().success}

    def left() -> set[int]:
        answer = site.ask(srv.GetFilters, f'{site.server}/get_filters')
        return mine & set(answer.active_filter_ids)

    site.wait_for(lambda: not left(), 'the end of the leases')
    return '' if len(mine) == LEASES else f'{len(mine)} of {LEASES} leases were given'
