"""The process of sensors says that it compiles, until it says anything else."""

import multiprocessing
import threading

import pytest

from drake_geom_ros.ros.sensing import node_pipe as tested
from drake_geom_ros.ros.sensing.node_pipe import NodePipe
from drake_geom_ros.ros.sensing.protocol import ALIVE, COMPILING

pytestmark = pytest.mark.clock

PATIENCE = 60.0  # [s]


@pytest.fixture
def ends(monkeypatch):
    """Return the ends of a pipe, that of the node first; signs are given each 10 ms."""
    monkeypatch.setattr(tested, '_SIGN', 0.01)
    node_end, process_end = multiprocessing.Pipe()
    with node_end, process_end:
        yield node_end, NodePipe(process_end)


def test_signs_are_given_until_something_is_sent(ends):
    node_end, pipe = ends
    pipe.send(ALIVE)
    pipe.may_compile()
    said = []
    while said.count(COMPILING) < 3:
        assert node_end.poll(PATIENCE)
        said.append(node_end.recv())
    assert said == [ALIVE, COMPILING, COMPILING, COMPILING]
    pipe.send(ALIVE)
    while said[-1] != ALIVE:
        said.append(node_end.recv())
    assert not node_end.poll(0.1)


def test_whole_messages_arrive_whoever_sends_them(ends):
    node_end, pipe = ends
    large = b'x' * 100_000  # more than the pipe holds
    for _ in range(20):
        pipe.may_compile()
        assert node_end.poll(PATIENCE)
        assert node_end.recv() == COMPILING
    node_end.send('task')
    assert pipe.recv() == 'task'
    received = []

    def receive():
        while len(received) < 20:
            if (said := node_end.recv()) != COMPILING:
                received.append(said)

    listening = threading.Thread(target=receive)
    listening.start()
    for _ in range(20):
        pipe.may_compile()
        pipe.send(large)
    listening.join(PATIENCE)
    assert received == [large] * 20


def test_signs_end_where_compiling_is_not_believed_any_more(ends, monkeypatch):
    node_end, pipe = ends
    monkeypatch.setattr(tested, '_LONGEST', 0.0)
    pipe.may_compile()
    assert not node_end.poll(0.1)
