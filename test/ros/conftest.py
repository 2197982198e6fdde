"""What tests of a node share."""

import pytest

# ROS is imported by the fixtures that need it: the tests of conversions run without.


@pytest.fixture(scope='module')
def server():
    """Return the full name of the node that the tests of a file ask."""
    return '/scene_graph'


@pytest.fixture(scope='module')
def module_client(request, server):
    """Return a client for all tests of a file: to find a node may take longer than a test."""
    from ros.harness import Client

    if 'shared_node' in request.fixturenames:
        yield request.getfixturevalue('shared_node').client
        return
    client = Client(server)
    yield client
    client.close()


@pytest.fixture
def client(node, module_client):
    """Return a client of the node, and show the node's log when it died."""
    yield module_client
    module_client.forget_topics()
    assert node.popen.poll() is None, f'the node died:\n{node.output()}'
