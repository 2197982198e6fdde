"""A node in a process of its own for each file of faults, as for the other ROS tests."""

from ros.conftest import client, lone_client, node

__all__ = ['client', 'lone_client', 'node']
