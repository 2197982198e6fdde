"""The page without a browser: what viser is told to show, and what its controls do."""

import io
import re
import threading
from dataclasses import replace
from urllib.parse import unquote

import numpy as np
import pytest
import trimesh
from viewing.page.pages import TEXT, page_of, value, wait_for
from viewing.scenes import PRESSING, local_scene
from viewing.test_batches import looks_of_shapes

from drake_geom_ros.geometry import Box, FramePoseVector, GeometryError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.viewing.cell_layers import CellLayer
from drake_geom_ros.viewing.page import serving
from drake_geom_ros.viewing.page.page import Page
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.shown_scene import ShownGeometries, ShownMoment
from drake_geom_ros.viewing.timeline import Timeline

GREEN = (0.0, 0.6, 0.4, 0.9)


@pytest.fixture
def opened():
    with page_of(TEXT) as (page, scene):
        yield page, scene


def labels(page):
    return [row.label for row in page.answer.rows if row.visible]


def test_the_table_is_the_answer_of_the_core(opened):
    page, scene = opened
    pairs = scene.moment(1.0, 'exact').pairs
    told = [round(1000.0 * d, 3) for d in pairs.distance.tolist()]
    # Rows are filled one after the other.
    wait_for(
        lambda: [float(label.split()[0]) for label in labels(page)] == told, f'a table of {told}'
    )
    said = '4 geometries; 3 pairs within 1 m, 0 of them overlap'
    wait_for(lambda: said in page._status.content, 'the status')


def test_the_sliders_are_the_question(opened):
    page, scene = opened
    page.answer.max_distance.value = 0.15
    wait_for(lambda: len(page.moment.pairs) == 1, 'one pair')
    page.answer.level.value = 0
    wait_for(lambda: page.answer.accuracy == 'bound' and page.moment, 'bounds')
    assert page.moment.pairs.distance == pytest.approx(scene.moment(0.15, 'bound').pairs.distance)


def test_a_row_selects_in_the_picture_and_the_picture_in_the_table(opened):
    page, _ = opened
    wait_for(lambda: labels(page), 'a table')
    page.answer._clicked(1, None)
    pair = tuple(page.moment.pairs.ids[1].tolist())
    assert page.selected == pair
    wait_for(lambda: page.answer.rows[1].color == 'violet', 'a marked row')
    names = page.moment.geometries.names
    assert [text.value for text in page.filters.texts] == [names[v] for v in pair]
    said = [*(names[v] for v in pair), labels(page)[1].partition(' mm ')[0] + ' mm']
    wait_for(lambda: re.findall('<div>(.*?)</div>', page.answer.details.content) == said, 'names')
    for name in ('s::a/ball', 't::b/pen'):
        page.choose(value(page, name))
    assert page.selected == tuple(sorted(value(page, n) for n in ('s::a/ball', 't::b/pen')))
    wait_for(lambda: sum(row.color == 'violet' for row in page.answer.rows) == 1, 'one row')
    page.choose(10**9)  # of a scene of before
    assert page.selected is not None


def test_filters_are_explained_and_switched(opened):
    page, _ = opened
    page.filters.choose_pair(('s::a/ball', 't::b/pen'))
    assert 'Reported' in page.filters.explanation.content
    page.filters._declare(page._scene.exclude, None)
    assert 'Filtered by: transient declaration' in page.filters.explanation.content
    wait_for(lambda: len(page.moment.pairs) == 2, 'a pair less')
    (switch,) = page.filters._switches
    switch.value = False
    wait_for(lambda: len(page.moment.pairs) == 3, 'the pair again')
    assert 'Reported' in page.filters.explanation.content
    page.filters.texts[0].value = 's::a/bal'
    assert 's::a/ball' in page.filters.explanation.content
    page.filters.choose_pair(('s::a/ball', 't::b/seen'))
    assert 'proximity role' in page.filters.explanation.content


def test_a_frame_is_moved_and_the_distance_follows(opened):
    page, scene = opened
    page.motion.frame.value = 't::b'
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


def test_the_time_line_of_a_motion_shows_what_is_proved():
    scene = local_scene(TEXT)
    frame = scene.frames['t', 'b']

    def poses(time):  # the pen touches the ball from time 0.2 on
        return FramePoseVector({frame: RigidTransform([1.0, 0.5 - time, 0.0])})

    timeline = Timeline(np.linspace(0.0, 0.5, 5), poses, is_continuous=True)
    with page_of(scene, timeline=timeline) as (page, _):
        wait_for(lambda: len(page.motion._proved) == 4, 'what is proved')
        assert page.motion._proved == ['clear', 'contact', 'contact', 'contact']
        wait_for(lambda: unquote(page.motion._plot.content).count('y="0.95"') == 2, 'the strip')
        plotted = unquote(page.motion._plot.content)
        assert re.findall(
            r'<rect x="([\d.]+)" y="0.95" height="0.05" width="[\d.]+" fill', plotted
        )
        assert '<b style="color:#e03131">contact</b>' in page.motion._plot.content


def test_a_motion_is_played_and_its_least_distance_found():
    scene = local_scene(TEXT)
    frame = scene.frames['t', 'b']
    ys = [0.5, 0.4, 0.31, 0.6]
    vectors = [FramePoseVector({frame: RigidTransform([1.0, y, 0.0])}) for y in ys]
    timeline = Timeline.of_moments([0.0, 0.1, 0.2, 0.3], vectors)
    with page_of(scene, timeline=timeline) as (page, _):
        wait_for(lambda: np.isfinite(page.motion._least).all(), 'the plot')
        # The pen is 0.1 m above the floor, and y - 0.3 m from the ball.
        assert page.motion._least == pytest.approx([0.1, 0.1, 0.01, 0.1])
        page.motion.go_to_least()
        assert page.motion.time.value == pytest.approx(0.2)
        plotted = unquote(page.motion._plot.content)
        assert '>100.000 mm<' in plotted
        assert '>10.000 mm<' in plotted
        assert re.findall(r'([\d.]+),([\d.]+)', plotted) == [
            *(('0.0000', '0.1200'), ('0.3333', '0.1200')),
            *(('0.6667', '0.8800'), ('1.0000', '0.1200')),
        ]
        assert scene.X_WF(('t', 'b')).translation()[1] == 0.31
        page.motion.time.value = 0.0
        page.motion.play.value = True
        wait_for(lambda: page.motion.time.value > 0.1, 'time to pass')
        page.motion.play.value = False


def surfaces(scene):
    """Return the surfaces that a local scene has now, as they are drawn."""
    return scene.moment(0.0, 'exact', contacts=True).patches


def test_contact_surfaces_are_shown_while_they_are_wished_for():
    with page_of(PRESSING) as (page, scene):
        shown = page.picture._surfaces
        assert shown._handle is None
        assert 'contact surface' not in page._status.content
        page.answer.contacts.value = True
        wait_for(lambda: shown._handle is not None, 'a surface')
        sent = trimesh_of(shown._handle)
        patches = surfaces(scene)
        assert sent.triangles.shape == (len(patches), 3, 3)
        corners = patches.vertices[patches.triangles]
        np.testing.assert_allclose(sent.triangles, corners, rtol=0, atol=1e-6)
        said = '1 contact surface, from no pressure (dark blue) to'
        wait_for(lambda: said in page._status.content, 'what is said of it')
        assert 'NOT SHOWN: 1 pair that overlaps without a contact surface' in page._status.content
        # Without a surface the one before is not left there.
        scene.place(('scene', 'ball'), RigidTransform([0, 0, 1.0]))
        wait_for(lambda: shown._handle is None, 'nothing')
        wait_for(lambda: '0 contact surfaces' in page._status.content, 'that there is none')


def trimesh_of(handle):
    """Return what a node of viser is told to draw."""
    loaded = trimesh.load(io.BytesIO(handle.glb_data), file_type='glb')
    return loaded.to_geometry()


def test_an_unforeseen_error_is_told_and_the_page_goes_on(opened, monkeypatch):
    page, scene = opened
    moment = scene.moment
    monkeypatch.setattr(scene, 'moment', lambda *_, **__: 1 / 0)
    page.touch()
    wait_for(lambda: 'ZeroDivisionError' in page._status.content, 'the error')
    monkeypatch.setattr(scene, 'moment', moment)
    page.touch()
    wait_for(lambda: 'geometries' in page._status.content, 'the page')


def test_names_with_markup_are_text():
    name = '<img src=x onerror="alert(1)">'
    text = f"""
frames: [{{name: '{name}', pose: {{}}}}, {{name: '[x](javascript:1)'}}]
geometries:
- {{name: '<b>/..', frame: '{name}', shape: {{type: sphere, radius: 0.1}}}}
- {{name: post, shape: {{type: sphere, radius: 0.1}}}}
"""
    with page_of(text) as (page, _):
        wait_for(lambda: 'without a pose' in page._status.content, 'the status')
        page.filters.choose_pair((f'scene::{name}/<b>/..', '<script>'))
        page.select(tuple(page.moment.pairs.ids[0].tolist()))
        wait_for(lambda: '&lt;b&gt;' in page.answer.details.content, 'the names of the pair')
        shown = (
            page._status.content + page.filters.explanation.content + page.answer.details.content
        )
        for tag in ('<img', '<b>', '<script'):
            assert tag not in shown
        page.answer._names.value = True
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
        page.answer._names.value = True
        wait_for(lambda: 'names of the first 300 only' in page._status.content, 'the remark')
        wait_for(lambda: len(page.picture._names) == 300, 'so many names')
        assert page.motion is None  # there is nothing to be moved
        page.filters.choose_pair(('geometry 1', 'geometry 9999'))
        assert 'anchored' in page.filters.explanation.content
    assert told[-1] == (10_000, 10_000)


def aim(page):
    """Return where browsers look that come now, and from how far."""
    camera = page._server.initial_camera
    return camera.look_at.tolist(), float(np.linalg.norm(camera.position - camera.look_at))


def test_browsers_look_at_what_is_there_once_there_is_something():
    crowd = Crowd(0)  # a node that has told of nothing yet
    with page_of(crowd) as (page, _):
        _, before = aim(page)
        for count, middle in ((11, 15.0), (21, 30.0)):  # and of more, later
            crowd.show(count)
            wait_for(lambda middle=middle: aim(page)[0] == [middle, middle + 1, middle + 2], 'aim')
            wait_for(lambda before=before: aim(page)[1] > before, 'a camera farther away')
            _, before = aim(page)


@pytest.mark.clock
def test_many_hands_at_once_leave_a_page_that_answers(opened):
    page, _ = opened

    def drag(seed):
        random = np.random.default_rng(seed)
        for y in random.uniform(-1.0, 1.0, 50):
            page.motion.place('t::b', [1.0, y, 0.0, 0.0, 0.0, 0.0, 1.0])
            page.answer.max_distance.value = float(abs(y))
            page.choose(value(page, 't::b/pen'))

    hands = [threading.Thread(target=drag, args=(seed,)) for seed in range(4)]
    for hand in hands:
        hand.start()
    for hand in hands:
        hand.join()
    page.answer.max_distance.value = 1.0
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
        wait_for(lambda: set(page.sensors.sources) == {'front', 'rear'}, 'a box for each source')
        assert 'front: 3 cells' in page.sensors.lines.content
        assert 'front: 1 hidden by bodies' in page.sensors.lines.content
        page.sensors.sources['front'].value = False
        wait_for(lambda: set(drawn) == {('rear', 'obstacles')}, 'those of the rear one')
        assert drawn['rear', 'obstacles'][1] is rear, 'what did not change is not sent again'
        page.sensors.kinds['obstacles'].value = False
        wait_for(lambda: not drawn, 'nothing')
        scene.layers = []
        scene.changes += 1
        wait_for(lambda: not page.sensors.sources, 'no box without a source')
