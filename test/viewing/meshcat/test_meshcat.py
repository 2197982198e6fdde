"""Meshcat's calls over our page, beside pydrake's Meshcat where that is installed."""

import inspect
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from ported.pydrake_names import arguments

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryError,
    HalfSpace,
    MeshcatCone,
    PointCloud,
    Rgba,
    Sphere,
    SurfaceTriangle,
    TriangleSurfaceMesh,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix

pytest.importorskip('viser', reason='draws the page')

from drake_geom_ros.viewing.meshcat import Meshcat, MeshcatParams, StartMeshcat

TRIANGLE = TriangleSurfaceMesh([SurfaceTriangle(0, 1, 2)], [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.fixture(scope='module')
def served():
    meshcat = Meshcat(0)
    yield meshcat
    meshcat.close()


@pytest.fixture
def meshcat(served):
    """Return the page of the file, empty."""
    served.Delete('/')
    served.DeleteAddedControls()
    return served


@pytest.fixture(scope='module')
def theirs():
    geometry = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
    return geometry.Meshcat()


def nodes(meshcat):
    """Return viser's nodes by name, those that pages get."""
    return meshcat._server.scene._handle_from_node_name


def test_every_call_takes_the_keywords_of_pydrake(theirs):
    kind, bad = type(theirs), []
    shared = [n for n in vars(Meshcat) if not n.startswith('_') and hasattr(kind, n)]
    assert {'SetObject', 'SetTransform', 'AddSlider', 'HasPath', 'Delete'} <= set(shared)
    for name in shared:
        for names in arguments(name, getattr(kind, name).__doc__):
            plain = [each.rstrip('=') for each in names]
            try:
                inspect.signature(getattr(Meshcat, name)).bind(None, **dict.fromkeys(plain))
            except TypeError as error:
                bad.append(f'{name}({", ".join(plain)}): {error}')
    assert bad == []


def test_paths_exist_as_in_pydrake(meshcat, theirs):
    from pydrake.geometry import Sphere as TheirSphere
    from pydrake.math import RigidTransform as TheirPose

    theirs.Delete('/')
    steps = [
        lambda m, ball, pose: m.SetObject('foo/bar', ball),
        lambda m, ball, pose: m.SetTransform('a/b/', pose),
        lambda m, ball, pose: m.SetProperty('p/q', 'visible', False),
        lambda m, ball, pose: m.SetObject('/top//x', ball),
        lambda m, ball, pose: m.Delete('foo/bar'),
        lambda m, ball, pose: m.Delete('nothing'),
        lambda m, ball, pose: m.Delete('a'),
        lambda m, ball, pose: m.Delete(),
        lambda m, ball, pose: m.Delete('/top/x'),
    ]
    asked = ['foo', 'foo/', 'foo/bar', '/drake/foo', '/foo', 'foo//bar', 'a', 'a/b', 'b', 'p/q']
    asked += ['/', '/drake', '/top', '/top/x', 'top']
    for number, step in enumerate(steps):
        step(meshcat, Sphere(1), RigidTransform())
        step(theirs, TheirSphere(1), TheirPose())
        ours = {path: meshcat.HasPath(path) for path in asked}
        assert ours == {path: theirs.HasPath(path) for path in asked}, number


def test_an_object_stands_where_the_poses_along_its_path_place_it(meshcat):
    X_WA = RigidTransform(RotationMatrix.MakeZRotation(0.3), [1, 2, 3])
    meshcat.SetObject('a/b', Box(1, 2, 3), Rgba(1, 0, 0, 0.5))
    meshcat.SetTransform('a', X_WA)
    meshcat.SetTransform('a/b', matrix=RigidTransform([0, 0, 1]).GetAsMatrix4())
    there = nodes(meshcat)
    np.testing.assert_allclose(there['/drake/a'].position, [1, 2, 3])
    np.testing.assert_allclose(there['/drake/a'].wxyz, X_WA.rotation().ToQuaternion().wxyz())
    np.testing.assert_allclose(there['/drake/a/b'].position, [0, 0, 1])
    mesh = there['/drake/a/b/<object>/0']
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [1, 2, 3])
    assert (tuple(mesh.color), mesh.opacity) == ((255, 0, 0), 0.5)
    meshcat.SetProperty('a', 'visible', False)
    assert not there['/drake/a'].visible


@pytest.mark.parametrize(
    ('shape', 'size'),
    [
        (Sphere(0.5), [1, 1, 1]),
        (Cylinder(0.5, 2), [1, 1, 2]),
        (Capsule(0.5, 2), [1, 1, 3]),
        (Ellipsoid(0.5, 1, 1.5), [1, 2, 3]),
        (MeshcatCone(2, 0.5, 1), [1, 2, 2]),
        (
            Convex(
                points=np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3.0]]).T, label='hull'
            ),
            [1, 2, 3],
        ),
        (TRIANGLE, [1, 1, 0]),
    ],
)
def test_a_shape_is_as_large_as_it_is(meshcat, shape, size):
    meshcat.SetObject('shape', shape)
    parts = [n for name, n in nodes(meshcat).items() if name.startswith('/drake/shape/<object>/')]
    points = np.concatenate(
        [
            RigidTransform(RotationMatrix(np.array(quaternion_matrix(p.wxyz))), p.position)
            .multiply(p.vertices.T.astype(float))
            .T
            for p in parts
        ]
    )
    np.testing.assert_allclose(np.ptp(points, axis=0), size, rtol=0, atol=1e-6)


def quaternion_matrix(wxyz):
    w, x, y, z = wxyz
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def test_an_object_replaces_the_one_before_and_nothing_below_its_path(meshcat):
    meshcat.SetObject('a', Capsule(0.1, 1))
    meshcat.SetObject('a/b', Sphere(1))
    meshcat.SetObject('a', Sphere(1))
    names = [name for name in nodes(meshcat) if name.startswith('/drake/a/')]
    assert sorted(names) == [
        '/drake/a/<object>',
        '/drake/a/<object>/0',
        '/drake/a/b',
        '/drake/a/b/<object>',
        '/drake/a/b/<object>/0',
    ]
    meshcat.SetObject('plane', HalfSpace())
    meshcat.Delete()
    assert [name for name in nodes(meshcat) if name.startswith('/drake')] == []


def test_lines_meshes_and_points(meshcat):
    points = np.array([[0, 1, 2], [0, 0, 1], [0, 0, 0.0]])
    meshcat.SetLine('line', points, 3.0, Rgba(0, 1, 0))
    line = nodes(meshcat)['/drake/line/<object>/lines']
    np.testing.assert_array_equal(line.points, [points[:, [0, 1]].T, points[:, [1, 2]].T])
    meshcat.SetTriangleMesh(
        'mesh', points, [[0], [1], [2]], wireframe=True, side=Meshcat.SideOfFaceToRender.kFrontSide
    )
    mesh = nodes(meshcat)['/drake/mesh/<object>/mesh']
    assert (mesh.wireframe, mesh.side) == (True, 'front')
    meshcat.SetObject('cloud', cloud=PointCloud(0.02, points.T), point_size=0.1)
    cloud = nodes(meshcat)['/drake/cloud/<object>/points']
    np.testing.assert_allclose(cloud.points, points.T)
    assert cloud.point_size == pytest.approx(0.1)


def test_sliders_round_as_in_pydrake(meshcat, theirs):
    theirs.DeleteAddedControls()
    for name, *numbers in [('u', 0, 1, 0.3, -2), ('s', 0, 1, 0.3, 0.5), ('v', 1, 2, 0.25, 1.4)]:
        ours = meshcat.AddSlider(name, *numbers)
        assert ours == pytest.approx(theirs.AddSlider(name, *numbers))
        for value in (0.1, 0.16, 0.99, -3.0, 0.74, 0.76, 0.15, 0.45):
            ours = meshcat.SetSliderValue(name, value)
            assert ours == pytest.approx(theirs.SetSliderValue(name, value)), (name, value)
            assert meshcat.GetSliderValue(name) == ours
    assert meshcat.GetSliderNames() == theirs.GetSliderNames() == ['s', 'u', 'v']
    # pydrake leaves the range here.
    assert meshcat.AddSlider('t', -1, 1, 0.4, 5) == pytest.approx(0.8)
    assert meshcat.AddSlider('w', 0.5, 0.6, 4, 9) == 0.6  # no multiple is within


def test_names_of_controls_are_unique_and_missing_ones_are_refused(meshcat, theirs):
    theirs.DeleteAddedControls()
    calls = [
        ('AddSlider', 's', 0, 1, 0.1, 0.2),
        ('AddSlider', 's', 0, 1, 0.1, 0.2),
        ('AddButton', 's'),
        ('AddButton', 'b'),
        ('AddSlider', 'b', 0, 1, 0.1, 0.2),
        ('AddButton', 'b', 'KeyG'),
        ('AddButton', 'b', 'KeyH'),
        ('GetButtonClicks', 'b'),
        ('GetButtonClicks', 'x'),
        ('GetSliderValue', 'x'),
        ('SetSliderValue', 'b', 1.0),
        ('DeleteSlider', 'x', False),
        ('DeleteSlider', 'x'),
        ('DeleteButton', 'b'),
        ('DeleteButton', 'b'),
        ('GetButtonNames',),
        ('DeleteAddedControls',),
        ('GetSliderNames',),
    ]
    for name, *arguments_ in calls:
        answers = []
        for each in (meshcat, theirs):
            try:
                answers.append(getattr(each, name)(*arguments_))
            except RuntimeError:
                answers.append('RuntimeError')
        assert answers[0] == pytest.approx(answers[1]), (name, arguments_)


def test_clicks_and_keys_count(meshcat):
    meshcat.AddButton('go', 'KeyG')
    button = meshcat._controls._buttons['go']
    (command,) = button.commands
    assert command.hotkey == 'G'
    for callback in (*button.handle._impl.update_cb, *command._impl.trigger_cb):
        callback(None)
    assert meshcat.GetButtonClicks('go') == 2
    meshcat.AddButton('go')
    assert meshcat.GetButtonClicks('go') == 0
    meshcat.AddSlider('turn', -1, 1, 0.25, 0.9, 'ArrowLeft', 'ArrowRight')
    less, more = meshcat._controls._sliders['turn'].commands
    assert (less.hotkey, more.hotkey) == ('arrowleft', 'arrowright')
    for command, value in ((more, 1.0), (more, 1.0), (less, 0.75)):
        command._impl.trigger_cb[0](None)
        assert meshcat.GetSliderValue('turn') == value


@pytest.mark.parametrize(
    ('name', 'given', 'words'),
    [
        ('SetObject', ('a', None), 'SetObject takes one'),
        ('SetObject', ('a', Sphere(1), 0.1), 'rgba=0.1'),
        ('SetObject', (3, Sphere(1)), 'path=3'),
        ('SetObject', ('/', Sphere(1)), 'the root'),
        ('SetTransform', ('a',), 'one of X_ParentPath and matrix'),
        ('SetTransform', ('a', np.diag([2.0, 2, 2, 1])), 'is not a rotation'),
        ('SetLine', ('a', np.zeros((2, 3))), r'vertices has the shape \(2, 3\)'),
        ('SetLineSegments', ('a', np.zeros((3, 2)), np.zeros((3, 3))), 'start has 2 points'),
        ('SetTriangleMesh', ('a', np.zeros((3, 3)), [[0], [1], [5]]), 'vertices 0 to 5'),
        ('SetTriangleMesh', ('a', np.zeros((3, 3)), [[0.0], [1], [2]]), 'must be integers'),
        ('AddSlider', ('a', 1, 0, 0.1, 0), 'min=1 must be <= max=0'),
        ('AddSlider', ('a', 0, 1, 0, 0), 'step=0 > 0'),
        ('AddSlider', ('a', 0, 1, 0.1, np.nan), 'value=nan'),
        ('AddSlider', ('a', 0, 1, 0.1, 0, 'Any'), "keycode='Any'"),
        ('AddButton', ('a', 'Any'), "keycode='Any'"),
        ('SetCameraPose', ([0, 0, 1], [0, 0, 1]), 'cannot look at'),
        ('SetCameraPose', ([0, 0], [0, 0, 1]), r'camera_in_world=\[0.0, 0.0\]'),
    ],
)
def test_bad_arguments_are_refused_and_change_nothing(meshcat, name, given, words):
    with pytest.raises(RuntimeError, match=words):
        getattr(meshcat, name)(*given)
    assert not meshcat.HasPath('a')
    assert meshcat.GetSliderNames() == meshcat.GetButtonNames() == []


def test_properties_of_meshcat_itself_are_a_warning(meshcat):
    with pytest.warns(UserWarning, match="'/Background', 'visible'"):
        meshcat.SetProperty('/Background', 'visible', False)
    assert not meshcat.HasPath('/Background')


def test_a_port_that_is_taken_is_refused_and_names_that_are_missing_say_so(served):
    with pytest.raises(GeometryError, match=f'port={served.port()} is taken'):
        Meshcat(MeshcatParams(port=served.port()))
    with pytest.raises(ArgumentError, match='port=80'):
        Meshcat(80)
    with pytest.raises(AttributeError, match='differences_from_pydrake'):
        served.StartRecording()


def test_it_starts_and_says_where(capsys):
    meshcat = StartMeshcat()
    try:
        assert meshcat.web_url() in capsys.readouterr().out
        assert meshcat.port() >= 7000
        assert meshcat.GetNumActiveConnections() == 0
        meshcat.Flush()
    finally:
        meshcat.close()


def test_geometry_says_where_it_is():
    with pytest.raises(ImportError, match=r'drake_geom_ros\.viewing\.meshcat'):
        from drake_geom_ros.geometry import StartMeshcat as _  # noqa: F401


@pytest.mark.processes
@pytest.mark.everything
@pytest.mark.timeout(600)
def test_a_browser_shows_objects_and_moves_a_slider(meshcat, tmp_path):
    """The page of docs/viewing.md; ``KEEP_PICTURE`` names a file for it."""
    from bench.viewer.browser import PROGRAM, Browser

    if PROGRAM is None:
        pytest.skip('there is no chromium (apt-get install chromium)')
    meshcat.SetObject('arm/hand', Sphere(0.1), Rgba(1, 0.5, 0))
    meshcat.SetObject('table', Box(1, 1, 0.05))
    way = np.array([[0, 0.3, 0.5], [0, 0, 0.2], [0.2, 0.3, 0.2]])
    meshcat.SetLine('arm/way', way, 3.0, Rgba(0, 0, 1))
    meshcat.AddSlider('height', 0, 1, 0.01, 0.3, increment_keycode='KeyU')
    meshcat.AddButton('again')
    meshcat.SetTransform('arm', RigidTransform([0, 0, meshcat.GetSliderValue('height')]))
    meshcat.SetCameraPose([1.2, -1.2, 0.9], [0, 0, 0.2])
    browser = Browser(meshcat.web_url())
    try:
        browser.wait_for(lambda: meshcat.GetNumActiveConnections() == 1, 'the connection')
        browser.wait_for(lambda: 'again' in browser.text(), 'the panel')
        picture = Path(os.environ.get('KEEP_PICTURE', tmp_path / 'page.png'))

        def colours():
            # A remark that WebGL is done by software would be in the picture.
            browser.ask("document.querySelector('.mantine-Notification-closeButton')?.click()")
            browser.screenshot(picture)
            pixels = np.asarray(Image.open(picture).convert('RGB')).reshape(-1, 3).astype(int)
            red, green, blue = pixels.T
            orange = ((red > 150) & (blue < 90) & (green > 60) & (green < 180)).sum()
            line = ((blue > 150) & (red < 90) & (green < 90)).sum()
            return min(orange, line) > 50

        browser.wait_for(colours, 'the orange ball and the blue line')
        x, y, *_ = browser.box(
            "[...document.querySelectorAll('button')].find(e => e.innerText === 'again')"
        )
        browser.click(x, y)
        browser.wait_for(lambda: meshcat.GetButtonClicks('again') == 1, 'the click')
        for kind in ('keyDown', 'keyUp'):
            browser.send(
                'Input.dispatchKeyEvent', type=kind, key='u', code='KeyU', windowsVirtualKeyCode=85
            )
        browser.wait_for(lambda: meshcat.GetSliderValue('height') == 0.31, 'the key')
    finally:
        browser.close()
