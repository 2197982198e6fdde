"""What all tests share: nodes and clients; tests that run at once are kept apart in ROS."""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

UNCOMPILED = os.environ.get('NUMBA_DISABLE_JIT') == '1'

# No test judges how long anything takes: whoever calls a kernel first compiles it. Uncompiled, as
# for mutants, kernels take some 100 times as long, and a mutant has to fail by the same examples.
settings.register_profile(
    'untimed',
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    max_examples=10 if UNCOMPILED else 100,
    derandomize=UNCOMPILED,
)
settings.load_profile('untimed')

pytest_plugins = [
    'plugins.marks',
    'plugins.tiers',
    'plugins.costs',
    'plugins.reruns',
    'plugins.reversed',
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


@pytest.fixture(scope='session')
def shared_nodes(tmp_path_factory):
    """Return a list of the node that the tests of a worker share; empty: nobody needed it yet."""
    nodes = []
    yield nodes
    for node in nodes:
        node.close()


@pytest.fixture(scope='module')
def node_settings():
    """Return the parameters that the shared node has for a file, which may override this."""
    return {'max_distance': 0.5}


@pytest.fixture(scope='module')
def shared_node(shared_nodes, node_settings, tmp_path_factory):
    """Return the node of the worker, with an empty scene; fail if a file leaves something on it.

    What is started and opened for the file is in its domain.
    """
    from ros.shared_node import SharedNode, domain_of_the_shared_node

    with domain_of_the_shared_node():
        if not shared_nodes:
            shared_nodes.append(SharedNode(tmp_path_factory.mktemp('node') / 'log'))
        (node,) = shared_nodes
        node.process.forget_output()
        node.set(**node_settings)
        yield node
        try:
            node.reset()
        except BaseException:
            shared_nodes.remove(node)  # the next file has a new one
            node.close()
            raise


@pytest.fixture(scope='module')
def node(shared_node):
    """Return the process of the shared node, unless a file has a node of its own."""
    return shared_node.process


@pytest.fixture
def lone_client():
    """Return a client for a test that starts nodes of its own."""
    from ros.harness import Client

    client = Client()
    yield client
    client.close()
