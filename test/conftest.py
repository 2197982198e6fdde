"""What all tests share: nodes and clients; tests that run at once are kept apart in ROS."""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

# No test judges how long anything takes: whoever calls a kernel first compiles it.
settings.register_profile('untimed', deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('untimed')

pytest_plugins = [
    'plugins.marks',
    'plugins.tiers',
    'plugins.costs',
    'plugins.reruns',
    'plugins.seed',
    'plugins.without_ros',
]

# ROS is imported by the fixtures that need it: most tests run without.


def pytest_configure(config):
    """Give each process of pytest-xdist but the first a ROS domain of its own.

    Under nohup, or in the background of a shell, SIGINT is ignored, and so it is by whatever is
    started: processes that tests interrupt would not notice.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    number = int(os.environ.get('PYTEST_XDIST_WORKER', 'gw0').removeprefix('gw'))
    if number and 'ROS_DOMAIN_ID' in os.environ:
        # 1 to 101, as ``run`` hands them out.
        domain = 1 + (int(os.environ['ROS_DOMAIN_ID']) - 1 + 37 * number) % 101
        os.environ['ROS_DOMAIN_ID'] = str(domain)


@pytest.fixture(scope='module')
def node(tmp_path_factory, request):
    """Return a node with an empty scene, in a process of its own, for one test file."""
    from ros.harness import start_node

    log = tmp_path_factory.mktemp('node') / 'log'
    process = start_node(log, max_distance=0.5)
    yield process
    process.end()


@pytest.fixture
def lone_client():
    """Return a client for a test that starts nodes of its own."""
    from ros.harness import Client

    client = Client()
    yield client
    client.close()
