"""The page without a browser: what viser is told to show, and what its controls do."""

import io
import json
import re
import threading
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from viewing.page.pages import TEXT, do, page_of, value, wait_for
from viewing.scenes import PRESSING, local_scene
from viewing.test_batches import looks_of_shapes

from drake_geom_ros.geometry import Box, FramePoseVector, GeometryError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.viewing.cell_layers import CellLayer
from drake_geom_ros.viewing.extents import Extent
from drake_geom_ros.viewing.looks import PALETTE
from drake_geom_ros.viewing.page import sections, serving
from drake_geom_ros.viewing.page.board import Board
from drake_geom_ros.viewing.page.browsers import read_command
from drake_geom_ros.viewing.page.cameras import PRESETS, fitted
from drake_geom_ros.viewing.page.commands import Commands
from drake_geom_ros.viewing.page.options import CommandError, ViewOptions
from drake_geom_ros.viewing.page.page import Page
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.shown_scene import ShownGeometries, ShownMoment
from drake_geom_ros.viewing.snapshot import looking
from drake_geom_ros.viewing.timeline import Timeline

GREEN = (0.0, 0.6, 0.4, 0.9)


@pytest.fixture
def opened():
    with page_of(TEXT) as (page, scene):
        yield page, scene


def rows(page):
    """Return the rows of the table: ids, distance [m] and error bound [m]."""
    return (page.board.value('pairs') or {'rows': []})['rows']


def names_of(page, *values):
    return [page.moment.geometries.names[value] for value in values]


def test_the_table_is_the_answer_of_the_core(opened):
    page, scene = opened
    pairs = scene.moment(1.0, 'exact').pairs
    wait_for(lambda: len(rows(page)) == 3, 'a table')
    assert [row[:2] for row in rows(page)] == pairs.ids.tolist()
    assert [row[2] for row in rows(page)] == pytest.approx(pairs.distance.tolist(), abs=1e-9)
    assert [row[3] for row in rows(page)] == pairs.error_bound.tolist()
    assert page.board.value('pairs')['count'] == 3
    assert page.board.value('pairs')['overlaps'] == 0


def test_the_colour_of_a_source_is_that_of_its_bodies_not_of_the_ground(opened):
    page, _ = opened
    scene = sections.scene_section(page.moment.geometries, 'scene')
    expected = {
        name: [round(255.0 * part) for part in colour[:3]]
        for name, colour in zip('st', PALETTE, strict=False)
    }
    assert dict(scene['sources']) == expected


def test_the_options_are_the_question(opened):
    page, scene = opened
    do(page, 'option', name='max_distance', value=0.15)
    wait_for(lambda: len(page.moment.pairs) == 1, 'one pair')
    do(page, 'option', name='accuracy', value='bound')
    bounds = scene.moment(0.15, 'bound').pairs.distance.tolist()
    wait_for(lambda: page.moment.pairs.distance.tolist() == bounds, 'bounds')
    assert page.board.value('options')['accuracy'] == 'bound'
    do(page, 'option', name='accuracy', value='1e-3')
    assert page.board.value('options')['accuracy'] == '0.001'


@pytest.mark.parametrize(
    ('name', 'value', 'allowed'),
    [
        ('max_distance', -1.0, 'from 0 to 1000'),
        ('max_distance', float('nan'), 'from 0 to 1000'),
        ('max_distance', '1', 'a number'),
        ('accuracy', 'best', 'balanced'),
        ('accuracy', 3, 'a text'),
        ('layers', ['ground'], 'illustration'),
        ('layers', 'proximity', 'a list'),
        ('hidden', [1], 'a text'),
        ('hidden_cells', ['none'], 'shadow'),
        ('grid', 1, 'true or false'),
        ('colour', True, 'max_distance'),
    ],
)
def test_options_that_cannot_be_are_refused_and_change_nothing(name, value, allowed):
    options = ViewOptions()
    with pytest.raises(CommandError, match=re.escape(allowed)):
        options.changed(name, value)


@pytest.mark.parametrize(
    ('command', 'reason'),
    [
        ({'do': 'selekt', 'bodies': []}, 'do you mean|is no command'),
        ({'do': '__init__', 'page': None}, 'is no command'),
        ({'do': 'select'}, "missing a required argument: 'bodies'"),
        ({'do': 'select', 'bodies': [1, 1]}, 'two different ids'),
        ({'do': 'select', 'bodies': [[]]}, 'is no body'),
        ({'do': 'select', 'bodies': [10**9]}, 'is no body'),
        ({'do': 'select', 'bodies': [], 'more': 1}, 'unexpected'),
        ({'do': 'time', 'value': 1.0}, 'no motion'),
        ({'do': 'joint', 'name': 'a', 'value': 0.0}, 'is no joint'),
        ({'do': 'frame', 'name': 'a'}, 'is no frame'),
        ({'do': 'declare', 'allow': True}, 'select two bodies'),
        ({'do': 'switch', 'row': 0, 'on': True}, 'row must be'),
        ({'do': 'view', 'name': 'behind'}, 'front'),
        ({'do': 'view', 'name': 'fit'}, 'not there yet'),
        ({'do': 'look', 'position': [0, 0], 'look_at': [0, 0, 0]}, '3 numbers'),
        ({'do': 'poses', 'format': 'xml'}, 'yaml, csv'),
    ],
)
def test_commands_that_cannot_be_are_refused_with_the_reason(opened, command, reason):
    page, _ = opened
    before = page.options, page.selection
    with pytest.raises(CommandError, match=reason):
        Commands(page).execute('test', command)
    assert (page.options, page.selection) == before


@pytest.mark.parametrize(
    'text', ['', '{', '[]', '{}', '{"do": 1}', '[' * 50_000, 'x' * 200_000, b'a']
)
def test_a_message_that_is_no_command_is_refused(text):
    with pytest.raises(CommandError, match='a command is'):
        read_command(text)


def test_the_first_click_fills_a_and_the_second_b(opened):
    page, _ = opened
    ball, pen, floor = (value(page, n) for n in ('s::a/ball', 't::b/pen', 's::world/floor'))
    page.pick(ball)
    assert page.selection.values == (ball,)
    page.pick(pen)
    assert page.selection.values == (ball, pen)
    page.pick(floor)
    assert page.selection.values == (floor,)
    page.pick(floor)
    assert page.selection.values == ()
    page.pick(10**9)  # of a scene of before
    assert page.selection.values == ()


def test_two_bodies_have_their_distance_whatever_it_is(opened):
    """Beyond max_distance, filtered, and moved: 0.5 m between axes, less both radii."""
    page, scene = opened
    do(page, 'option', name='max_distance', value=0.0)
    ball, pen = value(page, 's::a/ball'), value(page, 't::b/pen')
    do(page, 'select', bodies=[pen, ball])

    def pair():
        return (page.board.value('selection') or {}).get('pair') or {}

    def shown(distance):
        return abs(pair().get('distance', np.inf) - distance) < 1e-9

    wait_for(lambda: shown(0.2), 'the distance')
    assert pair()['reported'] is False
    wait_for(lambda: pair()['filter'] == '', 'that no filter excludes it')
    assert pair()['p_WCa'] == pytest.approx([1.0, 0.2, 0.0])
    assert pair()['p_WCb'] == pytest.approx([1.0, 0.4, 0.0])
    assert page.picture._selected_label._handle.text == '200.000 mm'
    do(page, 'declare', allow=False)
    wait_for(lambda: 'transient declaration' in pair()['filter'], 'the filter')
    assert shown(0.2)
    scene.place(('t', 'b'), RigidTransform([1.0, 0.35, 0.0]))
    wait_for(lambda: shown(0.05), 'the distance, which follows')
    scene.place(('t', 'b'), RigidTransform([1.0, 0.25, 0.0]))
    wait_for(lambda: shown(-0.05), 'the depth')


def test_bodies_without_a_distance_say_why(opened):
    page, _ = opened
    do(page, 'select', bodies=[value(page, 's::a/ball'), value(page, 't::b/seen')])

    def reason():
        return ((page.board.value('selection') or {}).get('pair') or {}).get('reason')

    wait_for(lambda: reason() == 't::b/seen has no proximity role, so it has no distance', 'why')


def test_a_selected_body_is_described(opened):
    page, _ = opened
    do(page, 'select_names', names=['t::b/pen', 'nobody'])
    wait_for(lambda: (page.board.value('selection') or {}).get('bodies'), 'the body')
    (body,) = page.board.value('selection')['bodies']
    told = dict(body['rows'])
    assert body['name'] == 't::b/pen'
    assert told['shape'] == 'capsule'
    assert told['radius'] == '100 mm'
    assert told['length'] == '400 mm'
    assert told['margin'] == '0 mm'
    assert told['role proximity'] == 'no properties'
    assert told['position'] == '1.0000 0.5000 0.0000 m'
    assert told['roll pitch yaw'] == '0.00° 0.00° 0.00°'


def test_selected_bodies_stand_out(opened):
    page, _ = opened
    pen = value(page, 't::b/pen')

    def colours():
        return [
            tuple(colour)
            for shown in page.picture._batches
            for colour in np.asarray(shown.handle.batched_colors)[shown.batch.geometries == pen]
            if shown.batch.layer == 'proximity'
        ]

    before = colours()
    do(page, 'select', bodies=[pen])
    wait_for(lambda: set(colours()) == {(160, 0, 255)}, 'the colour')
    do(page, 'select', bodies=[])
    wait_for(lambda: colours() == before, 'its own colour')


def test_a_hidden_source_is_not_drawn_and_its_lines_neither(opened):
    page, _ = opened

    def drawn():
        return {v for shown in page.picture._batches for v in shown.batch.geometries.tolist()}

    do(page, 'option', name='hidden', value=['t'])
    wait_for(lambda: drawn() == {value(page, n) for n in ('s::a/ball', 's::world/floor')}, 'those')
    lines = page.picture._lines['distances']._handle
    wait_for(lambda: len(lines.points) == 1, 'the line from the ball to the floor')
    assert len(rows(page)) == 3, 'the table has all pairs'
    hidden = 'hidden, with their lines: t'
    wait_for(lambda: hidden in page.board.value('status')['lines'], 'that some are hidden')
    do(page, 'option', name='hidden', value=[])
    wait_for(lambda: len(drawn()) == 4 and len(lines.points) == 3, 'all of them')


def test_filters_are_switched(opened):
    page, _ = opened
    do(page, 'select', bodies=[value(page, 's::a/ball'), value(page, 't::b/pen')])
    do(page, 'declare', allow=False)
    wait_for(lambda: len(page.moment.pairs) == 2, 'a pair less')
    assert page.board.value('filters') == [['exclude s::a/ball | t::b/pen', True]]
    do(page, 'switch', row=0, on=False)
    wait_for(lambda: len(page.moment.pairs) == 3, 'the pair again')
    assert page.board.value('filters') == [['exclude s::a/ball | t::b/pen', False]]


def test_a_frame_is_moved_and_put_back(opened):
    page, scene = opened
    do(page, 'frame', name='t::b')
    assert page.motion.gizmo is not None
    page.motion.place('t::b', [1.0, 0.35, 0.0, 0.0, 0.0, 0.0, 1.0])
    ball, pen = value(page, 's::a/ball'), value(page, 't::b/pen')

    def distance():
        row = page.moment.pairs.find((ball, pen))
        return row is not None and page.moment.pairs.distance[row]

    wait_for(lambda: abs(distance() - 0.05) < 1e-9, 'the distance')
    for hostile in ([np.nan] * 7, [0.0] * 7, [1.0]):
        page.motion.place('t::b', hostile)
    assert scene.X_WF(('t', 'b')).translation()[1] == 0.35
    do(page, 'reset')
    assert scene.X_WF(('t', 'b')).translation()[1] == 0.5
    assert page.motion.gizmo.position.tolist() == [1.0, 0.5, 0.0]
    do(page, 'frame', name='')
    assert page.motion.gizmo is None


def test_poses_are_kept_as_text(opened):
    page, _ = opened
    told = do(page, 'poses', format='csv')['file']
    assert told['name'] == 'poses.csv'
    assert told['text'].splitlines()[2] == 't::b,1.0,0.5,0.0,0.0,0.0,0.0,1.0'
    assert 'position: [1.0, 0.5, 0.0]' in do(page, 'poses', format='yaml')['file']['text']


def test_the_time_line_of_a_motion_shows_what_is_proved():
    scene = local_scene(TEXT)
    frame = scene.frames['t', 'b']

    def poses(time):  # the pen touches the ball from time 0.2 on
        return FramePoseVector({frame: RigidTransform([1.0, 0.5 - time, 0.0])})

    timeline = Timeline(np.linspace(0.0, 0.5, 5), poses, is_continuous=True)
    with page_of(scene, timeline=timeline) as (page, _):
        proved = ['clear', 'contact', 'contact', 'contact']
        wait_for(lambda: page.board.value('timeline')['outcomes'] == proved, 'what is proved')


def test_a_motion_is_played_and_its_least_distance_found():
    scene = local_scene(TEXT)
    frame = scene.frames['t', 'b']
    ys = [0.5, 0.4, 0.31, 0.6]
    vectors = [FramePoseVector({frame: RigidTransform([1.0, y, 0.0])}) for y in ys]
    timeline = Timeline.of_moments([0.0, 0.1, 0.2, 0.3], vectors)
    with page_of(scene, timeline=timeline) as (page, _):
        # The pen is 0.1 m above the floor, and y - 0.3 m from the ball.
        least = [0.1, 0.1, 0.01, 0.1]
        wait_for(lambda: page.board.value('timeline') is not None, 'the time line')
        wait_for(lambda: page.board.value('timeline')['least'] == pytest.approx(least), 'the plot')
        do(page, 'least')
        assert page.motion.time == pytest.approx(0.2)
        assert scene.X_WF(('t', 'b')).translation()[1] == 0.31
        for count, time in ((1, 0.3), (1, 0.3), (-1, 0.2), (-2, 0.0), (-1, 0.0)):
            do(page, 'step', count=count)
            assert page.motion.time == pytest.approx(time)
        do(page, 'time', value=0.15)
        do(page, 'step', count=1)
        assert page.motion.time == pytest.approx(0.2)
        do(page, 'time', value=0.15)
        do(page, 'step', count=-1)
        assert page.motion.time == pytest.approx(0.1)
        do(page, 'speed', value=0.5)
        do(page, 'reset')
        do(page, 'play', on=True)
        wait_for(lambda: page.motion.time > 0.1, 'time to pass')
        do(page, 'play', on=False)
        wait_for(lambda: page.board.value('clock')['playing'] is False, 'pause')
        assert page.board.value('clock')['speed'] == 0.5


def said_by(page):
    """Return what the page says about the moment."""
    status = page.board.value('status') or {'lines': [], 'troubles': []}
    return ' '.join(status['lines'] + status['troubles'])


def surfaces(scene):
    """Return the surfaces that a local scene has now, as they are drawn."""
    return scene.moment(0.0, 'exact', contacts=True).patches


def test_contact_surfaces_are_shown_while_they_are_wished_for():
    with page_of(PRESSING) as (page, scene):
        shown = page.picture._surfaces
        assert shown._handle is None
        assert 'contact surface' not in said_by(page)
        do(page, 'option', name='contacts', value=True)
        wait_for(lambda: shown._handle is not None, 'a surface')
        sent = trimesh_of(shown._handle)
        patches = surfaces(scene)
        assert sent.triangles.shape == (len(patches), 3, 3)
        corners = patches.vertices[patches.triangles]
        np.testing.assert_allclose(sent.triangles, corners, rtol=0, atol=1e-6)
        said = '1 contact surface, from no pressure (dark blue) to'
        wait_for(lambda: said in said_by(page), 'what is said of it')
        assert 'NOT SHOWN: 1 pair that overlaps without a contact surface' in said_by(page)
        # Without a surface the one before is not left there.
        scene.place(('scene', 'ball'), RigidTransform([0, 0, 1.0]))
        wait_for(lambda: shown._handle is None, 'nothing')
        wait_for(lambda: '0 contact surfaces' in said_by(page), 'that there is none')


def trimesh_of(handle):
    """Return what a node of viser is told to draw."""
    loaded = trimesh.load(io.BytesIO(handle.glb_data), file_type='glb')
    return loaded.to_geometry()


def test_an_unforeseen_error_is_told_and_the_page_goes_on(opened, monkeypatch):
    page, scene = opened
    moment = scene.moment
    monkeypatch.setattr(scene, 'moment', lambda *_, **__: 1 / 0)
    page.touch()
    wait_for(lambda: 'ZeroDivisionError' in said_by(page), 'the error')
    monkeypatch.setattr(scene, 'moment', moment)
    do(page, 'option', name='hidden', value=['t'])
    wait_for(lambda: 'hidden, with their lines: t' in said_by(page), 'the page')


def test_nodes_of_the_picture_are_named_by_numbers():
    text = """
frames: [{name: '<b>/..', pose: {}}, {name: '[x](javascript:1)'}]
geometries:
- {name: ball, frame: '<b>/..', shape: {type: sphere, radius: 0.1}}
- {name: post, shape: {type: sphere, radius: 0.1}}
"""
    with page_of(text) as (page, _):
        wait_for(lambda: 'without a pose' in said_by(page), 'the status')
        do(page, 'option', name='names', value=True)
        wait_for(lambda: len(page.picture._names) == 2, 'labels')
        assert all(handle.name.split('/')[-1].isdigit() for handle in page.picture._names.values())


class Crowd:
    """A scene of many boxes in rows, as its page sees it."""

    changes = 0

    def __init__(self, count):
        looks = looks_of_shapes(*[Box(0.5, 0.5, 0.5)] * count)
        names = {look.geometry.get_value(): look.name for look in looks}
        self.geometries = ShownGeometries(np.array(list(names)), looks, names)
        self.p_WGs = np.arange(3.0 * count).reshape(-1, 3)

    def show(self, count):
        """Show so many boxes from now on."""
        self.__init__(count)
        self.changes += 1

    def version(self):
        return self.changes

    def moment(self, max_distance, accuracy, *, contacts=False):
        Rs, none = np.tile(np.eye(3), (len(self.p_WGs), 1, 1)), np.zeros((0, 3))
        return ShownMoment(
            self.geometries, Rs, self.p_WGs, ReportedPairs.none(), np.zeros((0, 3, 3)), none
        )

    def explain(self, pair):
        return ['anchored']

    def body(self, value):
        return None


def test_ten_thousand_geometries_are_shown_with_progress(monkeypatch):
    told, progress = [], Page._progress
    monkeypatch.setattr(
        Page, '_progress', lambda page, *how: (told.append(how), progress(page, *how))
    )
    crowd = Crowd(10_000)
    with page_of(crowd) as (page, _):
        (shown,) = page.picture._batches
        np.testing.assert_array_equal(
            shown.handle.batched_positions, crowd.p_WGs.astype(np.float32)
        )
        do(page, 'option', name='names', value=True)
        wait_for(lambda: 'names of the first 300 only' in said_by(page), 'the remark')
        wait_for(lambda: len(page.picture._names) == 300, 'so many names')
        assert page.motion is None  # there is nothing to be moved
        do(page, 'select_names', names=['geometry 1', 'geometry 9999'])

        def pair():
            return (page.board.value('selection') or {}).get('pair') or {}

        wait_for(lambda: pair().get('filter') == 'filtered by anchored', 'the reason')
        assert 'no distance' in pair()['reason']
    assert told[-1] == (10_000, 10_000)


EXTENT = Extent(np.array([-0.1, -1.2, -0.1]), np.array([2.5, 0.5, 1.5]))


@pytest.mark.parametrize('name', PRESETS)
@pytest.mark.parametrize('aspect', [0.4, 1.0, 2.5])
def test_a_fitted_camera_has_all_in_sight_and_no_more_than_it_needs(name, aspect):
    fov = 1.2
    position, target = fitted(EXTENT, PRESETS[name], fov, aspect)
    corners = np.stack(np.meshgrid(*np.stack(EXTENT).T), axis=-1).reshape(-1, 3)
    X_WC = looking(position, target)
    inside = (corners - position) @ X_WC.rotation().matrix()  # x to the right, z ahead
    tangents = np.tan(fov / 2.0) * np.array([aspect, 1.0])
    shares = np.abs(inside[:, :2]) / (inside[:, 2:] * tangents)
    assert (inside[:, 2] > 0.0).all()
    assert 0.9 < shares.max() < 1.0


def test_a_board_tells_of_changes_only():
    board, told = Board(), []
    board.watch(lambda: told.append(1))
    board.put('a', {'x': [1.0, float('inf'), float('nan')]})
    board.put('a', {'x': [1.0, None, None]})
    board.put('b', 2)
    assert len(told) == 2
    serial, texts = board.newer_than(0)
    assert [json.loads(text)['section'] for text in texts] == ['a', 'b']
    board.put('a', 3)
    _, (text,) = board.newer_than(serial)
    assert json.loads(text) == {'section': 'a', 'value': 3}
    assert board.value('a') == 3


@pytest.mark.clock
def test_many_hands_at_once_leave_a_page_that_answers(opened):
    page, _ = opened

    def drag(seed):
        random = np.random.default_rng(seed)
        for y in random.uniform(-1.0, 1.0, 50):
            page.motion.place('t::b', [1.0, y, 0.0, 0.0, 0.0, 0.0, 1.0])
            do(page, 'option', name='max_distance', value=float(abs(y)))
            page.pick(value(page, 't::b/pen'))

    hands = [threading.Thread(target=drag, args=(seed,)) for seed in range(4)]
    for hand in hands:
        hand.start()
    for hand in hands:
        hand.join()
    do(page, 'option', name='max_distance', value=1.0)
    page.motion.place('t::b', [1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0])
    wait_for(lambda: len(page.moment.pairs) == 3, 'the answer')
    assert page.trouble == ''


def test_it_opens_on_this_machine_only_unless_told(opened):
    page, _ = opened
    assert page.host == '127.0.0.1'
    for host in ('127.0.0.1', '::1', 'localhost', '127.1.2.3'):
        assert serving.warning(host) == ''
    for host in ('0.0.0.0', '::', '192.168.1.2', 'robot.example'):
        assert 'no encryption' in serving.warning(host)


def test_without_viser_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__('sys').modules, 'viser', None)
    with pytest.raises(GeometryError, match="extra 'view'"):
        serving.open_server()


class Sensed(Crowd):
    """A crowd with maps of two sensors."""

    def __init__(self, count=1):
        super().__init__(count)
        self.layers = [
            CellLayer('front', 'obstacles', np.eye(3), np.array([1.0, 0, 0, 0]), 0.1, GREEN),
            CellLayer('front', 'shadow', np.ones((1, 3)), np.array([1.0, 0, 0, 0]), 0.1, GREEN),
            CellLayer('rear', 'obstacles', -np.eye(3), np.array([1.0, 0, 0, 0]), 0.2, GREEN),
        ]

    def moment(self, *arguments, **options):
        return replace(super().moment(*arguments, **options), cells=self.layers)


def test_layers_of_maps_are_drawn_and_chosen_by_kind_and_source():
    scene = Sensed()
    with page_of(scene) as (page, _):
        drawn = page.picture._cells
        every = {('front', 'obstacles'), ('front', 'shadow'), ('rear', 'obstacles')}
        wait_for(lambda: set(drawn) == every, 'all layers')
        rear = drawn['rear', 'obstacles'][1]
        np.testing.assert_array_equal(rear.batched_positions, -np.eye(3, dtype=np.float32))
        counts = {'obstacles': 3, 'shadow': 1}
        told = [['front', counts], ['rear', {'obstacles': 3}]]
        wait_for(lambda: (page.board.value('sensors') or {}).get('rows') == told, 'the sources')
        legend = [text for text, *_ in page.board.value('sensors')['colours']]
        assert legend == ['front, cells', 'hidden by bodies', 'rear, cells']
        do(page, 'option', name='hidden', value=['sensor front'])
        wait_for(lambda: set(drawn) == {('rear', 'obstacles')}, 'those of the rear one')
        assert drawn['rear', 'obstacles'][1] is rear, 'what did not change is not sent again'
        do(page, 'option', name='hidden_cells', value=['obstacles'])
        wait_for(lambda: not drawn, 'nothing')
        scene.layers = []
        scene.changes += 1
        wait_for(lambda: not page.board.value('sensors')['rows'], 'no row without a source')
