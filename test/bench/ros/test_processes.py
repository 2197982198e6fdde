"""Processes that are started are ended, by their own pids."""

import os

import pytest

from bench.ros.processes import Processes, memory


def start_and_fail(started):
    with Processes() as processes:
        started.append(processes.start('http.server', '--bind', '127.0.0.1', '0'))
        raise RuntimeError('boom')


def test_what_still_runs_is_ended_also_after_an_error():
    started = []
    with pytest.raises(RuntimeError, match='boom'):
        start_and_fail(started)
    assert started[0].poll() is not None


def test_parameters_are_ros_arguments():
    with Processes() as processes:
        process = processes.start('timeit', '-n1', '-r1', '-h', rate=3.0)
        assert process.args[-3:] == ['--ros-args', '-p', 'rate:=3.0']


def test_the_memory_of_a_process_is_in_megabytes():
    assert 5.0 < memory(os.getpid()) < 100_000.0
