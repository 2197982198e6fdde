"""The page inside a notebook."""

import http.server
import threading
import urllib.request

import pytest
from viewing.page.pages import wait_for
from viewing.scenes import registered

from drake_geom_ros.batch import Joints
from drake_geom_ros.geometry import ArgumentError, SceneGraph
from drake_geom_ros.scene_files import load_scene

pytest.importorskip('viser', reason='draws the page')

from bench.viewer.browser import PROGRAM, Browser
from drake_geom_ros.viewing.page.explore import explore

SCENE = """
frames: [{name: a, pose: {position: [1, 0, 0]}}]
geometries:
- {name: post, shape: {type: sphere, radius: 0.2}}
- {name: ball, frame: a, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def shown():
    shown = explore(registered(SCENE), max_distance=2.0, port=18600)
    yield shown
    shown.close()


def test_a_cell_shows_the_page_in_a_frame(shown):
    assert shown._repr_html_().startswith(f'<iframe src="{shown.url}"')
    assert len(shown.url.split('/')[3]) > 16, 'a token'
    wait_for(lambda: shown._page.moment is not None, 'the first picture')
    assert shown._page.moment.pairs.distance.tolist() == pytest.approx([0.7])


def test_a_state_is_shown_and_another_one():
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
    q = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
    shown = explore(scene_graph, joints, q, port=18600)
    try:
        wait_for(lambda: shown._page.moment is not None, 'the first picture')
        before = shown._page.scene.moment(0.5, 'exact').pairs.distance.tolist()
        shown.pose([0.2, *q[1:]])
        assert shown._page.scene.moment(0.5, 'exact').pairs.distance.tolist() != before
        shown.pose(q)
        again = shown._page.scene.moment(0.5, 'exact').pairs.distance.tolist()
        assert again == pytest.approx(before, rel=0, abs=1e-12)
    finally:
        shown.close()


def test_what_does_not_go_together_is_refused(shown):
    with pytest.raises(ArgumentError, match='joints and q go together'):
        explore(registered(SCENE), q=[0.0])
    with pytest.raises(ArgumentError, match='needs joints'):
        shown.pose([0.0])


def test_frames_of_other_pages_are_refused(shown):
    with urllib.request.urlopen(shown.url) as answer:
        policy = answer.headers['Content-Security-Policy']
    assert policy == "frame-ancestors 'self' http://localhost:* http://127.0.0.1:* vscode-webview:"


@pytest.mark.processes
@pytest.mark.everything
@pytest.mark.skipif(PROGRAM is None, reason='there is no chromium (apt-get install chromium)')
def test_a_notebook_of_this_machine_shows_it(shown):
    """A page of another port of this machine, as Jupyter's."""
    document = f'<p>notebook</p>{shown._repr_html_()}'.encode()

    class Notebook(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header('Content-Type', 'text/html')
            self.end_headers()
            self.wfile.write(document)

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Notebook)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    browser = Browser(f'http://localhost:{server.server_port}/')
    try:
        wait_for(shown._page._server.get_clients, 'the picture in the frame')
    finally:
        browser.close()
        server.shutdown()
