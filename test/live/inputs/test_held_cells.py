"""What a map holds of before does not depend on which process takes its messages."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from live.inputs.sensing_node import Node, cloud

from drake_geom_ros.live.inputs.obstacle_records import Held
from drake_geom_ros.live.inputs.point_taker import PointTaker

SPOTS = st.lists(st.tuples(*3 * [st.integers(-12, 12)]), min_size=1, max_size=6, unique=True)
STEPS = st.lists(
    st.fixed_dictionaries(
        {
            'spots': SPOTS,
            'after': st.floats(0.0, 1.5),
            'keep': st.sampled_from([0.0, 1.0, np.inf]),
            'rays': st.booleans(),
            'event': st.sampled_from(['', '', '', 'clear', 'jump']),
            'restarted': st.booleans(),
        }
    ),
    min_size=2,
    max_size=6,
)


def maps_after(steps, restarting):
    """Return the cells after each step, taken by another process where a step says so."""
    node = Node(self_filter='none')
    found = []
    for step in steps:
        if step['restarted'] and restarting:
            node.taker = PointTaker(node.input)
        if step['event'] == 'clear':
            node.input.forget()
        node.clock.now += 1000.0 if step['event'] == 'jump' else step['after']
        if step['event'] == 'jump':
            node.live.clocks.begin_anew()
        node.settings = node.settings._replace(keep=step['keep'], rays=step['rays'])
        points = 0.1 * np.array(step['spots']) + 0.05
        node.taker.take_cloud(cloud(points, stamp=node.clock.now))
        found.append((node.centres().tolist(), node.input.counts.held_cells))
    return found


@settings(max_examples=60)
@given(STEPS)
def test_another_process_holds_what_the_one_before_it_would(steps):
    assert maps_after(steps, restarting=True) == maps_after(steps, restarting=False)


def test_a_map_that_was_cleared_gives_nothing_to_another_process():
    node = Node(self_filter='none', keep=np.inf)
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    assert isinstance(node.input.begin(cloud([]).header).before, Held)
    node.input.forget()
    assert node.input.begin(cloud([]).header).before is None
    PointTaker(node.input).take_cloud(cloud([[0, 2, 0]]))
    assert len(node.centres()) == 1


def test_what_is_refused_leaves_what_is_held_as_it_was():
    node = Node(self_filter='none', keep=np.inf)
    node.taker.take_cloud(cloud([[1, 0, 0]]))
    before = node.input.begin(cloud([]).header).before
    for wrong in (cloud([[np.nan, 0, 0]]), cloud([[0, 2, 0]], frame='nobody')):
        try:
            node.taker.take_cloud(wrong)
        except RuntimeError:
            continue
        raise AssertionError('it was taken')
    assert node.input.begin(cloud([]).header).before is before
