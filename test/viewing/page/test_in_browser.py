"""The page of the demo's scene in a real browser: what people see and touch."""

import argparse
import importlib.metadata
import importlib.util
import itertools
import json
import time
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
from viewing.page.pages import TEXT, do, page_of, wait_for
from viewing.page.test_page import Crowd

from bench.viewer.browser import PROGRAM, Browser
from drake_geom_ros.command_line import view
from drake_geom_ros.command_line.program import main
from drake_geom_ros.viewing.extents import extent_of
from drake_geom_ros.viewing.page.cameras import PRESETS, fitted

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


CANVAS = "document.getElementById('picture')?.contentDocument?.querySelector('canvas')"


@pytest.fixture(scope='module')
def browser(page):
    browser = Browser(page.url, 1600, 1000)
    try:
        browser.wait_for(lambda: browser.ask(f'!!({CANVAS})'), 'a picture')
        if not drawn(browser):
            pytest.skip('this machine is too busy for a browser without a GPU')
        browser.wait_for(page._server.get_clients, 'the picture at the server')
        browser.wait_for(lambda: rows(browser), 'the table')
        yield browser
    finally:
        browser.close()


def only_client(page):
    """Return the page's only client, when that of a browser that was closed is gone."""
    clients = page._server.get_clients
    wait_for(lambda: len(clients()) == 1, 'one client')
    (client,) = clients().values()
    return client


@pytest.fixture(autouse=True)
def at_the_beginning(page, browser):
    yield
    do(page, 'select', bodies=[])
    do(page, 'option', name='max_distance', value=0.1)
    do(page, 'option', name='hidden', value=[])
    do(page, 'reset')
    open_tab(browser, 'pairs')
    search(browser, '')


def drawn(browser, frames=3):
    """Return whether a browser draws so many frames, which no page keeps it from, in a minute."""
    browser.ask(f'void (window.left = {frames}, (f = () => --left && requestAnimationFrame(f))())')
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        if browser.ask('left') <= 0:
            return True
        time.sleep(0.5)
    return False


def button(text):
    """Return an expression for the button with a text."""
    return f"[...document.querySelectorAll('button')].find(e => e.textContent === {text!r})"


def press(browser, expression):
    x, y, *_ = browser.box(expression)
    browser.click(x, y)


def open_tab(browser, name):
    browser.ask(f"document.getElementById('to-{name}').click()")


def search(browser, text):
    browser.ask(
        '(() => { const field = document.querySelector("input[type=search]");'
        f' field.value = {text!r}; field.dispatchEvent(new Event("input")); }})()'
    )


def rows(browser):
    """Return the cells of the table."""
    return browser.ask(
        "[...document.querySelectorAll('#pairs tbody tr')].map("
        'row => [...row.cells].map(cell => cell.textContent))'
    )


def distances(browser):
    return [float(row[0].split()[0]) for row in rows(browser)]


def test_the_numbers_are_those_of_the_core(page, browser):
    pairs = page.scene.moment(0.1, 'exact').pairs
    browser.wait_for(lambda: len(rows(browser)) == len(pairs), 'all rows')
    assert distances(browser) == pytest.approx((1000.0 * pairs.distance).tolist(), abs=5e-4)
    assert browser.ask('document.title') == 'two_pandas · drake_geom_ros'
    count = f'{len(pairs)} pairs within 0.1 m'
    browser.wait_for(lambda: count in browser.text(), 'the summary')


def test_the_table_is_sorted_searched_and_filtered(page, browser):
    shown = distances(browser)
    assert shown == sorted(shown)
    press(browser, "document.querySelector('#pairs th button')")
    browser.wait_for(lambda: distances(browser) == shown[::-1], 'the farthest first')
    press(browser, "document.querySelectorAll('#pairs th button')[1]")
    browser.wait_for(
        lambda: [row[1] for row in rows(browser)] == sorted(row[1] for row in rows(browser)),
        'the names in order',
    )
    press(browser, "document.querySelector('#pairs th button')")
    browser.wait_for(lambda: distances(browser) == shown, 'the nearest first')
    search(browser, 'rod fence')
    browser.wait_for(lambda: len(rows(browser)) == 1, 'one row')
    assert sorted(rows(browser)[0][1:]) == ['objects::rod', 'scenery::fence']
    search(browser, 'nobody')
    browser.wait_for(lambda: f'none of {len(shown)} pairs matches' in browser.text(), 'no row')
    search(browser, '')
    do(page, 'option', name='max_distance', value=1.0)
    browser.wait_for(lambda: 'and 940 more' in browser.text(), 'the number of the others')
    assert len(rows(browser)) == 60
    assert f'1000 nearest of {len(page.moment.pairs)} pairs' in browser.text()
    browser.ask(
        '(() => { const field = document.querySelector("select[aria-label=\'source or robot\']");'
        ' field.value = "left"; field.dispatchEvent(new Event("change")); })()'
    )
    browser.wait_for(lambda: all('left::' in f'{row}' for row in rows(browser)), 'one robot')
    browser.ask(
        '(() => { const field = document.querySelector("select[aria-label=\'source or robot\']");'
        ' field.value = ""; field.dispatchEvent(new Event("change")); })()'
    )


def test_a_row_that_is_clicked_on_is_selected_and_flown_to(page, browser):
    browser.wait_for(lambda: len(rows(browser)) > 2, 'the table')
    client = only_client(page)
    press(browser, "document.querySelectorAll('#pairs tbody tr')[2]")
    pair = tuple(page.moment.pairs.ids[2].tolist())
    wait_for(lambda: page.selection.pair == pair, 'the selection')
    middle = page.moment.pairs.segments()[2].mean(axis=0)
    browser.wait_for(
        lambda: np.allclose(client.camera.look_at, middle, rtol=0, atol=1e-3), 'the flight'
    )
    browser.wait_for(lambda: 'Queries report this pair.' in browser.text(), 'the explanation')
    assert browser.ask("document.querySelectorAll('#pairs tr.selected').length") == 1
    press(browser, button('fit'))
    wait_for(lambda: np.linalg.norm(client.camera.look_at - middle) > 0.1, 'the whole scene')


def test_a_body_that_is_clicked_on_is_selected(page, browser):
    # The page looks at the middle of the scene.
    x, y, *_ = browser.box("document.getElementById('picture')", covered=True)
    places = itertools.cycle((0, 40, 80, 120))

    def clicked():
        """Click where the last click did not select, for one may come before the page is ready."""
        if not page.selection.values:
            dy = next(places)
            browser.mouse('mouseMoved', x, y + dy)
            time.sleep(1.0)  # a browser without a GPU looks below the mouse after a while
            browser.click(x, y + dy)
            time.sleep(1.0)
        return page.selection.values

    browser.wait_for(clicked, 'a selected body')
    name = page.moment.geometries.names[page.selection.values[0]]
    browser.wait_for(lambda: name in browser.text(), 'its name')
    browser.wait_for(lambda: 'roll pitch yaw' in browser.text(), 'its pose')


def test_a_joint_is_moved_by_its_slider_in_degrees(page, browser):
    open_tab(browser, 'motion')
    press(
        browser,
        "[...document.querySelectorAll('summary')].find(e => e.textContent === 'joints of left')",
    )
    name, joint = next(iter(page.motion.joints.items()))
    slider = "document.querySelector('input[type=range][aria-label=panda_joint1]')"
    assert joint.is_angle
    assert float(browser.ask(f'{slider}.max')) == pytest.approx(np.degrees(joint.upper), abs=1e-3)
    before = page.motion.joint_values()[name]

    def moved():
        _, y, left, width = browser.box(slider)
        browser.click(left + 0.7 * width, y)
        return page.motion.joint_values()[name] != before

    browser.wait_for(moved, 'the joint')
    browser.wait_for(
        lambda: (
            abs(
                float(browser.ask(f'{slider}.value'))
                - np.degrees(page.motion.joint_values()[name])
            )
            < 0.01
        ),
        'the value in degrees',
    )

    def follows():
        now = page.scene.moment(0.1, 'exact').pairs.distance
        return np.array_equal(page.moment.pairs.distance, now)

    wait_for(follows, 'the answer')
    press(browser, button('reset to the beginning'))
    wait_for(lambda: page.motion.joint_values()[name] == before, 'the configuration')


def test_a_motion_is_played(page, browser):
    press(browser, button('play'))
    wait_for(lambda: page.motion.playing, 'play')
    wait_for(lambda: page.motion.time > 0.2, 'time to pass')
    press(browser, button('pause'))
    wait_for(lambda: not page.motion.playing, 'pause')


def test_a_click_in_the_plot_moves_the_time(page, browser):
    start, end = page.motion.timeline.start, page.motion.timeline.end
    for part in (0.25, 0.75):

        def clicked(part=part):
            _, y, left, width = browser.box("document.querySelector('.plot')", covered=True)
            browser.click(left + 64 + part * (width - 64 - 14), y)  # anywhere in its height
            time.sleep(0.3)
            return abs(page.motion.time - start - part * (end - start)) < 0.01 * (end - start)

        browser.wait_for(clicked, 'the moment that was clicked on')
    outcomes = "[...document.querySelectorAll('[data-outcome]')].map(e => e.dataset.outcome)"
    browser.wait_for(lambda: set(browser.ask(outcomes)) == {'clear', 'contact'}, 'what is proved')


def test_the_address_restores_the_view(page, browser):
    pair = page.moment.pairs.ids[1].tolist()
    do(page, 'select', bodies=pair)
    do(page, 'time', value=2.0)
    do(page, 'option', name='grid', value=True)
    client = only_client(page)
    press(browser, button('top'))

    def written():
        """Return the address of all that was done, which follows it after a while."""
        address = browser.ask('location.href')
        view = json.loads(unquote(urlsplit(address).fragment) or '{}')
        is_whole = 'selected' in view and view.get('time') == 2.0 and view['options']['grid']
        return is_whole and view.get('camera', {}).get('position', [0, 0, 0])[2] > 1.5 and address

    address = browser.wait_for(written, 'the address of the view from above')
    view = json.loads(unquote(urlsplit(address).fragment))
    do(page, 'select', bodies=[])
    do(page, 'time', value=0.0)
    do(page, 'option', name='grid', value=False)
    other = Browser(address, 900, 700)
    try:
        wait_for(lambda: set(page.selection.values) == set(pair), 'the selection')
        wait_for(lambda: page.motion.time == 2.0, 'the time')
        wait_for(lambda: page.options.grid, 'the grid')

        def looks():
            clients = [c for c in page._server.get_clients().values() if c is not client]
            return clients and np.allclose(
                clients[0].camera.position, view['camera']['position'], rtol=0, atol=1e-2
            )

        other.wait_for(looks, 'the camera')
    finally:
        other.close()


def test_the_ground_is_dark_or_light_for_each_browser(page, browser):
    ground = (
        "getComputedStyle(document.getElementById('picture').contentDocument.body).backgroundColor"
    )
    light = browser.ask(ground)
    press(browser, button('dark'))
    browser.wait_for(lambda: browser.ask(ground) != light, 'a dark picture')
    assert browser.ask('document.documentElement.dataset.theme') == 'dark'
    press(browser, button('light'))
    browser.wait_for(lambda: browser.ask(ground) == light, 'a light one')


def test_on_a_phone_the_panel_is_closed_at_first_and_all_is_in_sight(page, browser):
    clients = set(page._server.get_clients())
    phone = Browser('about:blank', 390, 844)
    try:
        phone.send(
            'Emulation.setDeviceMetricsOverride', width=390, height=844, deviceScaleFactor=1,
            mobile=True,
        )  # fmt: skip
        phone.send('Page.navigate', url=page.url)
        phone.wait_for(lambda: phone.ask(f'!!({CANVAS})'), 'a picture')
        assert phone.ask("document.getElementById('panel').offsetParent") is None
        assert phone.ask('document.documentElement.scrollWidth') <= 390
        (new,) = wait_for(lambda: set(page._server.get_clients()) - clients, 'the camera')
        camera = page._server.get_clients()[new].camera
        extent = extent_of(page.moment)
        position, _ = fitted(extent, PRESETS['fit'], camera.fov, camera.aspect)
        assert camera.aspect < 0.8
        phone.wait_for(lambda: np.allclose(camera.position, position, rtol=0, atol=0.02), 'it')
        phone.ask("document.getElementById('toggle-panel').click()")
        phone.wait_for(lambda: rows(phone), 'the table')
    finally:
        phone.close()


def test_names_with_markup_are_text():
    name = '<img src=x onerror="document.title=1">'
    text = f"""
frames: [{{name: '{name}', pose: {{}}}}]
geometries:
- {{name: '<b>/..', frame: '{name}', shape: {{type: sphere, radius: 0.1}}}}
- {{name: post, shape: {{type: sphere, radius: 0.1}}}}
"""
    with page_of(text) as (page, _):
        do(page, 'select', bodies=page.moment.pairs.ids[0].tolist())
        hostile = Browser(page.url)
        try:
            hostile.wait_for(lambda: f'scene::{name}/<b>/..' in hostile.text(), 'the name as text')
            assert hostile.ask("document.querySelectorAll('img, td b').length") == 0
            assert 'drake_geom_ros' in hostile.ask('document.title')
        finally:
            hostile.close()


def test_a_number_and_its_unit_stand_in_one_line():
    cells = ['camera', 'camera/depth/image_rect_raw/of_a_long_name', '22', '11.68 s']
    table = {'title': 'Sensors', 'columns': ['sensor', 'topic', 'messages', 'age'], 'empty': ''}
    lines = (
        '(cell => { const r = document.createRange(); r.selectNodeContents(cell);'
        ' return new Set([...r.getClientRects()].map(each => each.top)).size; })'
        "([...document.querySelectorAll('td')].find(each => each.textContent === {!r}))"
    )
    with page_of(TEXT) as (page, _):
        live = Browser(page.url)
        try:
            live.wait_for(lambda: rows(live), 'the table')
            page.board.put('kind', {'live': True, 'title': page.title})
            page.board.put('tables', [{**table, 'rows': [[cells, True, None]]}])
            open_tab(live, 'live')
            live.wait_for(lambda: cells[3] in live.text(), 'the age')
            assert [live.ask(lines.replace('{!r}', repr(each))) for each in cells[2:]] == [1, 1]
        finally:
            live.close()


def test_a_browser_that_closes_in_the_middle_of_a_drag_harms_nobody(page, browser):
    other = Browser(page.url, 1200, 800)
    other.wait_for(lambda: rows(other), 'the table')
    open_tab(other, 'view')
    x, y, *_ = other.box("document.querySelector('input[type=range]')")
    other.mouse('mouseMoved', x, y)
    other.mouse('mousePressed', x, y)
    other.mouse('mouseMoved', x + 20, y)
    other.close()
    do(page, 'option', name='max_distance', value=0.05)
    browser.wait_for(lambda: 'within 0.05 m' in browser.text(), 'the other page')
    assert page.trouble == ''


def test_a_browser_that_waits_for_a_scene_looks_at_it_once_it_is_there():
    crowd = Crowd(0)
    with page_of(crowd) as (page, _):
        early = Browser(page.url)
        try:
            clients = page._server.get_clients
            wait_for(lambda: [each for each in clients().values() if each.camera], 'a camera')
            crowd.show(11)

            def looks_at_it():
                (client,) = clients().values()
                return np.allclose(client.camera.look_at, [15, 16, 17], rtol=0, atol=0.5)

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
