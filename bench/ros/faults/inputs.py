"""Faults of what comes in: parameters, transforms, requests, time, and the life cycle."""

from __future__ import annotations

import importlib.util
import math
from typing import Any

from drake_geom_msgs import msg, srv
from geometry_msgs.msg import TransformStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from bench.ros.faults.site import Site
from bench.ros.hostile import requests

HAS_TF = importlib.util.find_spec('tf2_msgs') is not None
LATE = 'sources: [late]\nframes: [{name: hand, source: late}]\n'
# Parameters, their values in the soak, and values at the ends of what may be.
ENDS: tuple[tuple[str, Any, tuple[Any, ...]], ...] = (
    ('max_distance', 0.1, (0.0, 5e-324, 1.7e308, math.inf)),
    ('rate', 0.0, (1e-3, 1e4)),
    ('time_budget', 0.0, (5e-324, 1.7e308, math.inf)),
    ('stale_after', 1.0, (0.0, 5e-324, math.inf)),
    ('point_threshold', 0.1, (0.0, 5e-324, math.inf)),
    ('max_answer_size', 64.0, (0.0, 2000.0)),
    ('filters_per_owner', 1000, (1, 1000000)),
    ('accuracy', 'exact', ('bound', 'fast', 'balanced')),
    ('publish_markers', False, (True,)),
)
FRAMES, FLOOD = 300, 200  # of a transform message, and such messages
FORWARD, BACK = 1000.0, -900.0  # [s] that simulated time jumps by
LEASE = 0.2  # [s]


def parameter_at_its_end(site: Site) -> str:
    """Set a parameter to what is just allowed, and back."""
    name, usual, ends = site.random.choice(ENDS)
    with site.alone():
        for value in (site.random.choice(ends), usual):
            parameters = [Parameter(name, value=value).to_parameter_msg()]
            service = f'{site.server}/set_parameters'
            answer = site.ask(SetParameters, service, parameters=parameters)
            if not answer.results[0].successful:
                return f'{name} {value}: {answer.results[0].reason}'
            site.spin(0.2)
    return ''


def hostile_request(site: Site) -> str:
    """Ask for what is refused."""
    entries = list(requests('objects', 'can', 'objects::can/can'))
    service, kind, fields, word = site.random.choice(entries)
    answer = site.ask(kind, f'{site.server}/{service}', **fields)
    if answer.success or word not in answer.message:
        return f'{service} says {answer.success}, {answer.message!r} without {word!r}'
    return ''


def tf_flood(site: Site) -> str:
    """Send transforms of frames that nobody knows, more than can be read; some are none."""
    from tf2_msgs.msg import TFMessage

    publisher = site.publisher(TFMessage, '/tf')
    entries = [TransformStamped(child_frame_id=f'flood_{k}') for k in range(FRAMES)]
    for k, entry in enumerate(entries):
        entry.header.frame_id = f'flood_{site.random.randrange(k + 2) - 1}'  # loops, too
        entry.transform.translation.x = site.random.uniform(-1.0, 1.0)
    good = serialize_message(TFMessage(transforms=entries))
    entries[-1].transform.rotation.w = math.nan
    bad = serialize_message(TFMessage(transforms=entries))
    for _ in range(FLOOD):
        publisher.publish(site.random.choice((good, good, bad)))
        site.spin(0.001)
    return site.trouble()


def clock_jumps(site: Site) -> str:
    """Let simulated time jump ahead and back and stop: a lease ends in real time all the same."""
    clock = site.publisher(Clock, '/clock')
    moment = site.random.uniform(1e3, 1e6)  # [s]

    def tell(seconds: float) -> None:
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(round(seconds * 1e9), 10**9)
        clock.publish(message)
        site.spin(0.05)

    tell(moment)
    answer = site.ask(
        srv.ApplyTransientFilter,
        f'{site.spare}/apply_transient_filter',
        declaration=msg.CollisionFilterDeclaration(),
        lease=LEASE,
    )
    for jump in site.random.sample((FORWARD, BACK), 2):
        moment += jump
        tell(moment)

    def is_active() -> bool:
        filters = site.ask(srv.GetFilters, f'{site.spare}/get_filters')
        return answer.filter_id in filters.active_filter_ids

    site.wait_for(lambda: not is_active(), 'the end of the lease')
    return ''


def cleanup(site: Site) -> str:
    """Clean the spare node up while it loads: it comes back with its scene."""
    before = site.ask(srv.SaveScene, f'{site.spare}/save_scene').text
    loading = site.client(srv.LoadScene, f'{site.spare}/load_scene')
    late = loading.call_async(srv.LoadScene.Request(text=LATE))
    site.spin(site.random.uniform(0.0, 0.1))
    for number in (
        Transition.TRANSITION_DEACTIVATE,
        Transition.TRANSITION_CLEANUP,
        Transition.TRANSITION_CONFIGURE,
        Transition.TRANSITION_ACTIVATE,
    ):
        transition = Transition(id=number)
        service = f'{site.spare}/change_state'
        if not site.ask(ChangeState, service, transition=transition).success:
            return f'transition {number} failed'
    after = site.ask(srv.SaveScene, f'{site.spare}/save_scene').text
    late.cancel()
    return '' if after == before else f'the scene came back as {after!r}'
