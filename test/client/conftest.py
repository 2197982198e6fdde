"""The node and the client of the ROS tests."""

from ros.conftest import lone_client, node

__all__ = ['lone_client', 'node']
