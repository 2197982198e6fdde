"""The plug-in that leaves out what needs ROS where ROS is missing."""

import io

import pytest
from conventions.source_tree import ROOT
from plugins import without_ros


@pytest.fixture
def no_ros(monkeypatch):
    monkeypatch.setattr(without_ros, 'MISSING', ['rclpy'])


class Reporter:
    """Takes the lines of a summary."""

    def __init__(self):
        self.text = io.StringIO()

    def write_line(self, line):
        print(line, file=self.text)


def test_every_folder_and_file_that_needs_ros_is_there():
    assert [path for path in without_ros.NEED_ROS if not path.exists()] == []


@pytest.mark.usefixtures('no_ros')
def test_what_needs_ros_is_left_out_and_nothing_else():
    assert without_ros.pytest_ignore_collect(ROOT / 'test/ros') is True
    assert without_ros.pytest_ignore_collect(ROOT / 'test/ros/test_names.py') is True
    assert without_ros.pytest_ignore_collect(ROOT / 'test/math') is None


@pytest.mark.usefixtures('no_ros')
def test_one_line_names_what_is_left_out_and_why():
    reporter = Reporter()
    without_ros.pytest_terminal_summary(reporter)
    (line,) = reporter.text.getvalue().splitlines()
    assert line.startswith('SKIPPED, no rclpy (ROS) here: ')
    assert 'test/ros, ' in line


def test_with_ros_nothing_is_left_out(monkeypatch):
    monkeypatch.setattr(without_ros, 'MISSING', [])
    reporter = Reporter()
    without_ros.pytest_terminal_summary(reporter)
    assert without_ros.pytest_ignore_collect(ROOT / 'test/ros') is None
    assert reporter.text.getvalue() == ''
