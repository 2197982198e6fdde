"""Messages of bodies wait for poses: none is lost, and poses wait for nobody."""

import threading

import pytest

from drake_geom_ros.live.inputs.waiting_bodies import WaitingBodies


class Queue:
    """A queue whose messages are letters; capital ones do more than move bodies."""

    def __init__(self):
        self.taken, self.calls = [], 0
        self.waiting = WaitingBodies(self.take, self.move, self.call)

    def take(self, message):
        self.taken.append(f'take {message.raw}')

    def move(self, message, scene):
        if message.raw.isupper():
            return False
        self.taken.append(f'move {message.raw} in {scene}')
        return True

    def call(self):
        self.calls += 1

    def add(self, letters):
        for letter in letters:
            self.waiting.add(letter, {})


@pytest.fixture
def queue():
    return Queue()


def test_poses_take_along_what_only_moves_bodies(queue):
    queue.waiting.move_with('scene')
    queue.add('ab')
    queue.waiting.move_with('scene')
    assert queue.taken == ['move a in scene', 'move b in scene']
    assert not queue.waiting
    assert not queue.calls


def test_other_messages_are_left_to_the_trackers_thread_in_their_order(queue):
    queue.add('aBc')
    queue.waiting.move_with('scene')
    assert queue.taken == ['move a in scene']
    assert queue.calls == 1
    assert len(queue.waiting) == 2
    queue.waiting.take_all()
    assert queue.taken == ['move a in scene', 'take B', 'take c']
    assert not queue.waiting


def test_poses_do_not_wait_while_a_message_is_taken(queue):
    taking, goes_on = threading.Event(), threading.Event()

    def take(message):
        taking.set()
        assert goes_on.wait(60.0)
        queue.taken.append(f'take {message.raw}')

    queue.waiting = WaitingBodies(take, queue.move, queue.call)
    queue.add('Ab')
    thread = threading.Thread(target=queue.waiting.take_all)
    thread.start()
    assert taking.wait(60.0)
    queue.waiting.move_with('scene')
    assert queue.taken == []
    goes_on.set()
    thread.join()
    assert queue.taken == ['take A', 'take b']


def test_what_fails_does_not_keep_the_queue(queue):
    def fail(message, scene):
        raise MemoryError

    queue.waiting = WaitingBodies(queue.take, fail, queue.call)
    queue.add('a')
    with pytest.raises(MemoryError):
        queue.waiting.move_with('scene')
    queue.waiting.take_all()
    assert queue.taken == ['take a']
