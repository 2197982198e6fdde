"""Messages that wait for poses hold up their own topic, and no other."""

from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.inputs.late_messages import LateMessages
from drake_geom_ros.live.scene.moments import UnknownYetError


class Sensor:
    """A topic whose message k is taken only where the time is ``known[k]`` or later."""

    def __init__(self, late, clock, topic, known=()):
        self.late, self.clock, self.topic, self.known = late, clock, topic, known
        self.taken, self.refused, self.dropped = [], [], 0

    def send(self, k, depth=1):
        def attempt():
            if self.clock[0] < self.known[k]:
                raise UnknownYetError('later')
            self.taken.append(k)

        refuse = self.refused.append
        self.dropped += self.late.take(self.topic, attempt, lambda error: refuse(k), depth)


def test_a_sensor_whose_poses_never_come_delays_no_other():
    clock = [0.0]
    late = LateMessages(0.5, lambda: clock[0])
    lost = Sensor(late, clock, 'lost', [99.0] * 9)
    good = Sensor(late, clock, 'good', [0.0] * 9)
    for k in range(9):
        clock[0] = 0.1 * k
        lost.send(k)
        good.send(k)
        late.retry()
        assert good.taken == list(range(k + 1))
    assert lost.taken == []
    assert lost.refused == [0]  # after 0.5 s; of those behind it the newest is left
    assert lost.dropped + len(lost.refused) < 9
    assert lost.dropped > 0
    assert good.dropped == 0
    assert len(late) == 1
    late.forget('lost')
    assert len(late) == 0


def test_what_is_refused_for_another_reason_does_not_wait():
    late, refused = LateMessages(), []

    def attempt():
        raise ArgumentError('no')

    late.take('a', attempt, refused.append)
    assert [str(error) for error in refused] == ['no']
    assert len(late) == 0


@given(
    waits=st.lists(st.floats(0.0, 2.0), min_size=1, max_size=12),
    depth=st.integers(1, 4),
    patience=st.floats(0.1, 1.0),
)
def test_each_message_is_taken_in_order_or_refused_or_overtaken(waits, depth, patience):
    clock = [0.0]
    late = LateMessages(patience, lambda: clock[0])
    known = [0.1 * k + wait for k, wait in enumerate(waits)]
    sensor = Sensor(late, clock, 'a', known)
    for k in range(len(waits)):
        clock[0] = 0.1 * k
        sensor.send(k, depth)
    while len(late):
        clock[0] += 0.05
        late.retry()
        assert clock[0] < 0.1 * len(waits) + len(waits) * (patience + 0.1)
    both = sensor.taken + sensor.refused
    assert sensor.taken == sorted(set(sensor.taken))
    assert len(set(both)) == len(both)
    assert len(waits) - 1 in both  # the newest is never overtaken
    if all(wait == 0.0 for wait in waits):
        assert sensor.taken == list(range(len(waits)))
