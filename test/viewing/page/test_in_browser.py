"""The page of the demo's scene in a real browser: what people see and touch."""

import argparse
import importlib.metadata
import importlib.util
import time
from urllib.parse import urlsplit

import numpy as np
import pytest
from viewing.page.pages import TEXT, page_of, wait_for
from viewing.page.test_page import Crowd

from bench.viewer.browser import PROGRAM, Browser
from drake_geom_ros.command_line import view
from drake_geom_ros.command_line.program import main

pytestmark = [
    pytest.mark.processes,
    pytest.mark.everything,
    pytest.mark.timeout(600),
    pytest.mark.skipif(
        importlib.util.find_spec('viser') is None,
        reason='viser, which draws the page, is not installed',
    ),
    pytest.mark.skipif(PROGRAM is None, reason='there is no chromium (apt-get install chromium)'),
]


@pytest.fixture(scope='module')
def page():
    parser = argparse.ArgumentParser()
    view.add_to(parser.add_subparsers())
    motion = ['--motion', 'scenes/two_pandas_motion.yaml', '--port', '18090']
    page = view.open_page(parser.parse_args(['view', 'scenes/two_pandas.yaml', *motion]))
    yield page
    page.close()


@pytest.fixture(scope='module')
def browser(page):
    browser = Browser(f'http://{page.host}:{page.port}')
    try:
        browser.wait_for(lambda: browser.ask("!!document.querySelector('canvas')"), 'a picture')
        if not drawn(browser):
            pytest.skip('this machine is too busy for a browser without a GPU')
        browser.wait_for(lambda: rows(browser), 'the table')
        yield browser
    finally:
        browser.close()


def drawn(browser, frames=3):
    """Return whether a browser draws so many frames, which no page keeps it from, in a minute."""
    browser.ask(f'void (window.left = {frames}, (f = () => --left && requestAnimationFrame(f))())')
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        if browser.ask('left') <= 0:
            return True
        time.sleep(0.5)
    return False


def element(text):
    """Return an expression for the innermost element that says just this."""
    return f"[...document.querySelectorAll('*')].filter(e => e.innerText === {text!r}).at(-1)"


def rows(browser):
    """Return the lines of the table: a distance and two names, shortened."""
    lines = browser.text().splitlines()
    return [line for line in lines if ' mm ' in line and ' | ' in line]


def test_the_numbers_are_those_of_the_core(page, browser):
    pairs = page._scene.moment(0.1, 'exact').pairs
    shown = rows(browser)
    assert [float(line.split()[0]) for line in shown] == pytest.approx(
        (1000.0 * pairs.distance[: len(shown)]).tolist(), abs=5e-4
    )


def test_no_row_of_the_table_is_cut(page, browser):
    cut = (
        "[...document.querySelectorAll('.mantine-Button-label')]"
        '.some(e => e.scrollWidth > e.clientWidth)'
    )
    names = page.moment.geometries.short_names.values()
    assert len(set(names)) == len(names)
    row = page.answer.rows[0]
    before = row.label
    for label, is_cut in ((3 * before, True), (before, False)):

        def seen(label=label, is_cut=is_cut):
            row.label = label  # again, where the table itself was drawn meanwhile
            return label in rows(browser) and browser.ask(cut) == is_cut

        browser.wait_for(seen, f'{label!r}, cut: {is_cut}')


def test_a_row_that_is_clicked_on_is_selected(page, browser):
    label = page.answer.rows[2].label
    assert [row.label for row in page.answer.rows].count(label) == 1  # arms of a kind differ
    x, y, *_ = browser.box(element(label))
    browser.click(x, y)
    wait_for(lambda: page.selected == page.answer._ids[2], 'the selection')
    a = page.moment.geometries.names[page.selected[0]]
    browser.wait_for(lambda: 'Reported' in browser.text(), 'the explanation')
    assert a == page.filters.texts[0].value


def test_a_geometry_that_is_clicked_on_is_chosen(page, browser):
    page.filters.choose_pair(('', ''))
    # The page looks at the middle of the scene.
    x, y, *_ = browser.box("document.querySelector('canvas')", covered=True)
    browser.click(x, y)
    wait_for(lambda: page.filters.texts[1].value, 'a geometry')
    assert page.filters.texts[1].value in page.moment.geometries.names.values()


def test_a_joint_is_moved_by_its_slider(page, browser):
    x, y, *_ = browser.box(element('Joints of left'))
    browser.click(x, y)
    joint, slider = next(iter(page.motion.sliders.items()))
    before = slider.value
    track = (
        "[...document.querySelectorAll('[role=slider]')].find(s => "
        f"+s.getAttribute('aria-valuemin') === {joint.lower} && s.offsetParent !== null)"
    )
    browser.wait_for(lambda: browser.ask(f'!!({track})'), 'the slider')

    def dragged():
        # Again until it is taken: what is above may still be changing its height.
        x, y, *_ = browser.box(track)
        browser.mouse('mouseMoved', x, y)
        browser.mouse('mousePressed', x, y)
        for step in range(1, 6):
            browser.mouse('mouseMoved', x + 8 * step, y)
        browser.mouse('mouseReleased', x + 40, y)
        return slider.value != before

    browser.wait_for(dragged, 'the joint')
    # Events of a drag go on coming for a while.
    wait_for(lambda: page.motion._joints.value(joint) == slider.value, 'the links')

    def follows():
        now = page._scene.moment(page.answer.max_distance.value, 'exact').pairs.distance
        return np.array_equal(page.moment.pairs.distance, now)

    wait_for(follows, 'the answer')


def test_a_motion_is_played(page, browser):
    x, y, *_ = browser.box(f'document.getElementById({element("play")}.htmlFor)')
    browser.click(x, y)
    wait_for(lambda: page.motion.play.value, 'play')
    wait_for(lambda: page.motion.time.value > 0.2, 'time to pass')
    browser.click(x, y)
    wait_for(lambda: not page.motion.play.value, 'pause')


def test_a_click_in_the_plot_moves_the_time(page, browser):
    track = "document.querySelector('div:has(> .least-distances) + div .mantine-Slider-track')"
    start, end = page.motion._timeline.start, page.motion._timeline.end
    for part in (0.25, 0.75):

        def clicked(part=part):
            _, y, left, width = browser.box(track)
            browser.click(left + part * width, y + 20.0)  # anywhere in its height
            time = page.motion.time.value
            return abs(time - start - part * (end - start)) < 0.01 * (end - start)

        browser.wait_for(clicked, 'the moment that was clicked on')
    assert browser.ask(f'{track}.getBoundingClientRect().height') > 100.0


def test_a_browser_that_closes_in_the_middle_of_a_drag_harms_nobody(page, browser):
    other = Browser(f'http://{page.host}:{page.port}')
    other.wait_for(lambda: rows(other), 'the table')
    track = "document.querySelectorAll('[role=slider]')[0]"
    x, y, *_ = other.box(track)
    other.mouse('mouseMoved', x, y)
    other.mouse('mousePressed', x, y)
    other.mouse('mouseMoved', x + 20, y)
    other.close()
    page.answer.max_distance.value = 0.05
    browser.wait_for(lambda: 'within 0.05 m' in browser.text(), 'the other page')
    assert page.trouble == ''


def test_a_browser_that_waits_for_a_scene_looks_at_it_once_it_is_there():
    crowd = Crowd(0)
    with page_of(crowd) as (page, _):
        early = Browser(f'http://{page.host}:{page.port}')
        try:
            clients = page._server.get_clients
            wait_for(lambda: [each for each in clients().values() if each.camera], 'a camera')
            crowd.show(11)
            wanted = page._server.initial_camera

            def looks_at_it():
                (client,) = clients().values()
                return np.allclose(client.camera.look_at, wanted.look_at, rtol=0, atol=1e-3) and (
                    np.allclose(client.camera.position, wanted.position, rtol=0, atol=1e-3)
                )

            early.wait_for(lambda: np.allclose(wanted.look_at, [15, 16, 17]), 'the scene')
            early.wait_for(looks_at_it, 'a camera that looks at it')
        finally:
            early.close()


def test_beyond_this_machine_a_browser_comes_in_by_the_address_with_the_token(page, browser):
    with page_of(TEXT, host='0.0.0.0') as (opened, _):
        path = urlsplit(opened.url).path
        guest = Browser(f'http://127.0.0.1:{opened.port}{path}')
        try:
            guest.wait_for(lambda: len(rows(guest)) == 3, 'the table')
            guest.send('Page.navigate', url=f'http://127.0.0.1:{opened.port}/')
            guest.wait_for(lambda: 'lacks its token' in guest.text(), 'the refusal')
        finally:
            guest.close()


def test_a_page_of_somebody_else_reads_nothing(page, browser):
    """A socket that another page opens, from another origin: the browser says which."""
    other = Browser('data:text/html,<p>another page')
    try:
        other.wait_for(lambda: 'another page' in other.text(), 'the other page')
        address, protocol = f'ws://127.0.0.1:{page.port}', f'viser-v{viser_version()}'
        other.ask(
            f'void (window.got = "", w = new WebSocket({address!r}, {protocol!r}),'
            ' w.onopen = () => got += "open", w.onerror = () => got += "refused")'
        )
        other.wait_for(lambda: other.ask('window.got'), 'an outcome')
        assert other.ask('window.got') == 'refused'
    finally:
        other.close()


def viser_version():
    return importlib.metadata.version('viser')


def test_wrong_files_are_said_in_one_line(capsys):
    assert main(['view', '/nowhere.yaml']) == 2
    assert main(['view', 'scenes/minimal.yaml', '--poses', '/nowhere.csv']) == 2
    assert capsys.readouterr().err.count('\n') == 2
