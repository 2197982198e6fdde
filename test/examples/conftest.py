"""The client of the ROS tests."""

from ros.conftest import lone_client

__all__ = ['lone_client']
