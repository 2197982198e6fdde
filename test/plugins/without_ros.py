"""Plug-in of pytest: without ROS, what needs it is left out, which one line reports."""

from importlib.util import find_spec
from pathlib import Path

TESTS = Path(__file__).parents[1]
NEED_ROS = tuple(
    TESTS / name
    for name in (
        *('bench/ros', 'client', 'config', 'launch', 'ros'),
        'examples/test_cell_launch.py',
        'examples/test_plans.py',
        'examples/test_stop_monitor.py',
        'examples/test_ur5_cell.py',
        'live/conversions/test_misread_numbers.py',
        'live/conversions/test_proximity_rules.py',
        'live/conversions/test_serialized_cloud.py',
        'live/scene/test_scene_cameras.py',
        'live/scene/test_half_spaces.py',
        'live/scene/test_scene_rules.py',
        'live/scene/test_senders.py',
        'live/test_guard.py',
        'replay/test_recomputed_decisions.py',
        'test_programs.py',
    )
)
MISSING = [name for name in ('rclpy', 'drake_geom_msgs') if find_spec(name) is None]


def pytest_ignore_collect(collection_path):
    """Leave out what needs ROS where ROS is missing; None leaves the decision to others."""
    needed = {collection_path, *collection_path.parents}.intersection(NEED_ROS)
    return True if MISSING and needed else None


def pytest_terminal_summary(terminalreporter):
    """Report what was left out, and why, in one line."""
    if MISSING:
        names = ', '.join(f'test/{path.relative_to(TESTS)}' for path in NEED_ROS)
        terminalreporter.write_line(f'SKIPPED, no {" and ".join(MISSING)} (ROS) here: {names}')
