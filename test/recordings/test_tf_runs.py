"""Messages of TF that are taken many at once pose, to the bit, as they do one by one."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from recordings import recorder

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.recordings import player
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.pair_sets import pair_sets
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.states import StateBlocks

SCENE = """
sources: [left, right, things]
frames:
  - {name: base, source: left}
  - {name: hand, source: left, parent: base}
  - {name: lid, source: left, parent: hand}
  - {name: hand, source: right}
  - {name: tool, source: right}
  - {name: mark, source: right, static: true}
  - {name: stand, source: things, pose: {position: [0, 0, 1]}}
  - {name: box, source: things}
geometries:
  - {name: palm, source: left, frame: hand, shape: {type: sphere, radius: 0.1}}
  - {name: tip, source: right, frame: tool, shape: {type: sphere, radius: 0.1}}
  - {name: crate, source: things, frame: box, shape: {type: sphere, radius: 0.1}}
"""
LEFT = (('odom', 'left/base'), ('left/base', 'wrist'), ('/wrist', 'left/hand'))
RIGHT = (('odom', 'right/hand'), ('right/hand', 'tool'))
MARK = (('tool', 'mark'),)  # the scene file says that it rests
THINGS = (('things/stand', 'box'),)
OTHERS = (('map', 'cart'), ('cart', 'wheel'))  # nothing of the scene hangs on these


def rows(rng, count):
    q = rng.normal(size=(count, 4))
    return np.hstack((rng.normal(size=(count, 3)), q / np.linalg.norm(q, axis=1)[:, None]))


def told(rng, stamp, edges):
    poses = rows(rng, len(edges))
    return recorder.transforms(stamp, *((*e, row) for e, row in zip(edges, poses, strict=True)))


def still(rng, t):
    chain = told(rng, t, [('world', 'odom'), ('left/hand', 'lid')])
    return t, '/tf_static', chain


def unusual(kind, rng, t):
    """Return a message (time, topic, message) that is no part of a run, or not always."""
    message = told(rng, t, LEFT)
    first, last = message.transforms[0], message.transforms[-1]
    if kind == 'nan':
        last.transform.translation.y = math.nan
    elif kind == 'quaternion':
        first.transform.rotation.w += 0.1
    elif kind == 'far':
        first.transform.translation.x = 1e300
    elif kind == 'parent':
        first.header.frame_id = 'world'
    elif kind == 'lost parent':
        first.header.frame_id = 'nowhere'
    elif kind == 'loop':
        first.header.frame_id = 'left/hand'
    elif kind == 'new name':
        message = told(rng, t, [*LEFT, ('wrist', 'things/late')])
    elif kind == 'second name':
        message = told(rng, t, [('odom', 'base')])
    elif kind == 'no name':
        last.child_frame_id = ''
    elif kind == 'stamps':
        last.header.stamp = recorder.stamp(t - 0.004)
    elif kind == 'no stamp':
        for each in message.transforms:
            each.header.stamp.sec = each.header.stamp.nanosec = 0
    elif kind == 'lagging':  # each is later than the one before, and was overtaken
        message = told(rng, 0.05 + t - 0.5, LEFT)
    elif kind == 'late':
        message = told(rng, t - 0.5, LEFT)
    elif kind == 'rewind':
        message = told(rng, t - 7.0, LEFT)
    elif kind == 'ahead':
        message = told(rng, t + 4.0, LEFT)
    elif kind == 'twice':
        message = told(rng, t, [LEFT[0], *LEFT])
    elif kind == 'part':
        message = told(rng, t, LEFT[1:2])
    elif kind == 'empty':
        message = recorder.transforms(t)
    elif kind == 'static':
        return still(rng, t)
    elif kind == 'static child':
        return t, '/tf_static', told(rng, t, LEFT[1:2])
    elif kind == 'handed over':
        return t, '/poses', recorder.frame_poses(t, ['right::tool'], rows(rng, 1))
    elif kind == 'stand':
        return t, '/poses', recorder.frame_poses(t, ['things::stand'], rows(rng, 1))
    return t, '/tf', message


KINDS = (
    *('nan', 'quaternion', 'far', 'parent', 'lost parent', 'loop', 'new name', 'second name'),
    *(
        'no name',
        'stamps',
        'no stamp',
        'late',
        'lagging',
        'rewind',
        'ahead',
        'twice',
        'part',
        'empty',
    ),
    *('static', 'static child', 'handed over', 'stand', 'pause', 'jump'),
)
STREAMS = ((LEFT,), (LEFT, RIGHT), (LEFT, RIGHT, OTHERS), (LEFT, THINGS, OTHERS), (RIGHT, MARK))


def messages(events, seed, *, clock):
    """Return a recording of streams of TF, in the order and with the events that were drawn."""
    rng = np.random.default_rng(seed)
    found, t, ahead = [still(rng, 0.0)], 0.0, 0.0
    for event in events:
        what, count = event
        if what in ('pause', 'jump'):
            t, ahead = (t + 2.5, ahead) if what == 'pause' else (t, ahead + 100.0)
            continue
        if isinstance(what, str):
            for _ in range(count):
                t += 0.004
                found.append(unusual(what, rng, t))
            continue
        for _ in range(count):
            t += 0.005
            if clock:
                now = recorder.BEGIN / 1e9 + t + ahead
                found.append((t, '/clock', recorder.clock(now)))
            late = rng.choice([0.0, 0.001])
            found += [
                (t + 0.001 * k, '/tf', told(rng, t + ahead - late, what[k]))
                for k in range(len(what))
                if rng.random() < 0.95
            ]
    return found


def played(run, scene, rate):
    """Return all that is told of a recording, and how many messages were taken in runs."""
    opened = opened_recording(
        run,
        scene=scene,
        topics=None,
        stale_after=1.0,
        accuracy='exact',
        world_frame='world',
        package_roots=(),
    )
    states = StateBlocks(opened.playback, pair_sets(['left:right', 'things:*']))
    found = []
    for block in Player(opened, states, rate).blocks():
        inspector = block.context_query().inspector()
        names = [inspector.full_name(FrameId(value)) for value in block.frames.tolist()]
        order = np.argsort(names)
        names.sort()
        for k, time in enumerate(block.times.tolist()):
            poses = block.poses[k, order].tobytes()
            found.append((time, names, poses, block.ages[k].tolist()))
    tf, playback = opened.playback.inputs.tf, opened.playback
    with playback.live.editing() as held:
        frames = [f for f in held.model.names.labels if held.query.is_placed(f)]
        now = [
            (
                held.model.names.labels[f],
                held.poses.since(f),
                held.query.X_WF(f).ToArray().tobytes(),
            )
            for f in frames
        ]
        now.append(
            held.poses.ages.newest_stamp
            and (held.poses.ages.newest_stamp.sec, held.poses.ages.newest_stamp.nanosec)
        )
        wrong = tf.troubles(held)
    children = sorted({c for edges in (LEFT, RIGHT, MARK, THINGS, OTHERS) for _, c in edges})
    edges = [
        edge and (edge.parent, edge.X_PC.tobytes(), edge.stamp, edge.since)
        for edge in map(tf.edge, children)
    ]
    return found, now, edges, wrong, playback.refused, playback.troubles


@pytest.fixture(scope='module')
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp('runs')
    (folder / 'cell.yaml').write_text(SCENE)
    return folder


def both_ways(place, told_of, rate):
    """Return what is told with runs and one by one, and how many messages were in runs."""
    number = len(list(place.iterdir()))
    run = recorder.record(place / str(number), told_of)
    real, shortest, taken = player.run_of, player._SHORTEST, 0

    def counted(inputs, scene, senders, count):
        nonlocal taken
        found = real(inputs, scene, senders, count)
        taken += count if found is not None else 0
        return found

    player.run_of = counted
    try:
        at_once = played(run, place / 'cell.yaml', rate)
        player._SHORTEST = 10**9
        return at_once, played(run, place / 'cell.yaml', rate), taken
    finally:
        player.run_of, player._SHORTEST = real, shortest


steady = st.tuples(st.sampled_from(STREAMS), st.integers(1, 24))
rare = st.tuples(st.sampled_from(KINDS), st.sampled_from([1, 1, 12]))
# Messages of poses beside transforms on which, after a loop, no frame of the scene hangs.
BESIDE_NOTHING = [
    *[('part', 1), ('stand', 12), ('part', 1), ('loop', 1), ('handed over', 1)],
    *[((RIGHT, MARK), 14), ((LEFT,), 18), ('stamps', 12), ((LEFT, RIGHT), 2)],
]
events = st.lists(st.one_of(steady, rare), min_size=4, max_size=10)


@settings(max_examples=40, deadline=None)
@example(events=BESIDE_NOTHING, seed=2283, clock=True, rate=0.0)
@given(
    events=events,
    seed=st.integers(0, 2**16),
    clock=st.booleans(),
    rate=st.sampled_from([0.0, 0.0, 61.0]),
)
def test_runs_of_tf_are_as_one_by_one(place, events, seed, clock, rate):
    told_of = messages(events, seed, clock=clock)
    at_once, one_by_one, _ = both_ways(place, told_of, rate)
    assert at_once == one_by_one


@pytest.mark.parametrize('kind', KINDS)
def test_each_unusual_message_is_taken_as_itself_and_runs_go_on_behind_it(place, kind):
    every = (LEFT, RIGHT, OTHERS)
    drawn = [(every, 40), (kind, 1), (every, 40), (kind, 20), (every, 40)]
    at_once, one_by_one, taken = both_ways(place, messages(drawn, 3, clock=kind == 'jump'), 0.0)
    assert at_once == one_by_one
    assert at_once[0]
    # Of a frame with two moving names it may change which counts, and with a frame that two
    # pose by turns nothing is simple: from there on one by one.
    assert taken > (100 if kind in ('second name', 'handed over') else 300)


@pytest.mark.parametrize('first', [LEFT[:1], (('odom', 'base'),)])
def test_which_of_two_names_is_followed_changes_where_it_does_one_by_one(place, first):
    """A frame follows its longer name, until nothing was heard of that for a second."""
    other = (('odom', 'base'),) if first == LEFT[:1] else LEFT[:1]
    drawn = [((first, RIGHT), 30), ((other, RIGHT), 300), ((first, other), 30)]
    at_once, one_by_one, taken = both_ways(place, messages(drawn, 5, clock=False), 0.0)
    assert at_once == one_by_one
    assert taken > 40
