"""What all tests share: tests that run at once are kept apart in ROS."""

import os


def pytest_configure(config):
    """Give each process of pytest-xdist but the first a ROS domain of its own."""
    number = int(os.environ.get('PYTEST_XDIST_WORKER', 'gw0').removeprefix('gw'))
    if number and 'ROS_DOMAIN_ID' in os.environ:
        # 1 to 101, as ``run`` hands them out.
        domain = 1 + (int(os.environ['ROS_DOMAIN_ID']) - 1 + 37 * number) % 101
        os.environ['ROS_DOMAIN_ID'] = str(domain)
