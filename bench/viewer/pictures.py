"""The pictures of docs/viewing.md: the page in a headless Chromium, clicked and photographed.

./run exec python -m bench.viewer.pictures [--out docs] [--node | --stop]
"""

from __future__ import annotations

import argparse
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
import yaml
from PIL import Image
from sensor_msgs.msg import JointState

from bench.viewer.browser import Browser
from drake_geom_ros.command_line import view
from drake_geom_ros.viewing.page.commands import Commands

_DESK, _PHONE = (1600, 1000), (390, 844)
# A gap of the arms at which the demo's motion enters rules, and bodies that rest on the table.
_RULES = """
proximity_rules:
- {name: hands off, set_a: left, set_b: right, level: stop, enter: 0.05, leave: 0.08}
- {name: go slowly, set_a: left, set_b: right, level: slow, enter: 0.2, leave: 0.25}
- {name: near the fence, set_a: right, set_b: fence, level: warn, enter: 0.3, leave: 0.35}
"""
_STOPPABLE = """
proximity_rules:
- {name: can stop, set_a: left, set_b: right, level: stoppable, decelerations: 3.0,
   reaction_time: 0.1, margin: 0.01}
"""
_READY = (-0.9, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8)  # [rad] of an arm that turns about its foot
_RESTS = (0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8)  # [rad] of the other one
# Values and speeds of joints, by their names.
_TURNING = {
    f'{arm}::panda_joint{k}': (q, 2.0 if (arm, k) == ('left', 1) else 0.0)
    for arm, values in (('left', _READY), ('right', _RESTS))
    for k, q in enumerate(values, start=1)
} | {f'{arm}::panda_finger_joint1': (0.02, 0.0) for arm in ('left', 'right')}
_SETTLING = 8.0  # [s] until a browser without a GPU has drawn a new view
_CANVAS = "document.getElementById('picture')?.contentDocument?.querySelector('canvas')"
_PROVED = "!!document.querySelector('[data-outcome]')"  # which may have to be compiled
_SELECTED = "!!document.querySelector('#selection details')"
_COLOURS = 256  # of a picture, which is a third as large so
_MEETING = 6.4  # [s] of the demo's motion, when its arms are nearest
_MOMENT = 5.35  # [s] of the demo's motion, with both arms above the table


def main() -> None:
    """Write the pictures."""
    parser = argparse.ArgumentParser(prog='python -m bench.viewer.pictures')
    parser.add_argument('--out', type=Path, default=Path('docs'))
    parser.add_argument('--node', action='store_true', help='the picture of a running node')
    parser.add_argument('--stop', action='store_true', help='the ghost of an arm that stops')
    options = parser.parse_args()
    if options.stop:
        with_ghost(options.out)
    elif options.node:
        with_node(options.out)
    else:
        with_demo(options.out)


def with_demo(out: Path) -> None:
    """Photograph the page of the demo's scene and motion."""
    parser = argparse.ArgumentParser()
    view.add_to(parser.add_subparsers())
    motion = ['--motion', 'scenes/two_pandas_motion.yaml', '--between', 'left:right']
    page = view.open_page(
        parser.parse_args(['view', 'scenes/two_pandas.yaml', *motion, '--port', '18300'])
    )
    commands = Commands(page)

    def do(name: str, /, **arguments: Any) -> None:
        commands.execute('', {'do': name, **arguments})

    try:
        browser = opened(page.url, *_DESK)
        browser.wait_for(lambda: browser.ask(_PROVED), 'what is proved')
        do('time', value=_MOMENT)
        names = ('left::panda_link5/collision_0', 'right::panda_link5/collision_0')
        do('select_names', names=list(names))
        browser.wait_for(lambda: browser.ask(_SELECTED), 'the selection')
        photograph(browser, out / 'viewing_page.png')
        for tab in ('motion', 'view'):
            press(browser, f'to-{tab}')
        browser.ask("document.querySelector('#selection details').open = true")
        press(browser, 'theme')
        do('option', name='grid', value=True)
        photograph(browser, out / 'viewing_dark.png')
        do('option', name='grid', value=False)
        browser.close()
        phone = opened(page.url, *_PHONE)
        photograph(phone, out / 'viewing_phone.png')
        phone.close()
    finally:
        page.close()


def with_node(out: Path) -> None:
    """Photograph the page of a running demo with three rules."""
    from bench.ros.beside import NODE, VIEWER
    from bench.ros.driver import MOTION, PLAYER, SCENE
    from bench.ros.processes import Processes

    with tempfile.TemporaryDirectory() as folder, Processes() as processes:
        scene = Path(folder) / 'cell.yaml'
        text = Path(SCENE).read_text(encoding='utf-8')
        scene.write_text(text + _RULES, encoding='utf-8')
        processes.start(NODE, scene_file=str(scene), max_distance=0.1)
        played = {'scene_file': str(scene), 'rate': 20.0}
        player = processes.start(PLAYER, trajectory_file=MOTION, **played)
        processes.start(VIEWER, port=18301, max_distance=0.2)
        time.sleep(_SETTLING)
        browser = opened('http://127.0.0.1:18301/', *_DESK)
        press(browser, 'to-live')
        photograph(browser, out / 'viewing_node.png')
        press(browser, 'to-rules')
        player.terminate()
        processes.forget(player)
        meeting = Path(folder) / 'meeting.yaml'
        meeting.write_text(until_arms_meet(Path(MOTION)), encoding='utf-8')
        processes.start(PLAYER, trajectory_file=str(meeting), loop=False, **played)
        browser.wait_for(lambda: browser.text().count('entered: near') == 2, 'two entered rules')
        photograph(browser, out / 'proximity_rules.png')
        browser.close()


def until_arms_meet(path: Path) -> str:
    """Return the demo's motion as far as its arms are nearest, without what they grasp."""
    motion = yaml.safe_load(path.read_text(encoding='utf-8'))
    for robot in motion['robots'].values():
        robot['waypoints'] = [each for each in robot['waypoints'] if each['at'] <= _MEETING]
    return yaml.safe_dump({'robots': motion['robots']})


def with_ghost(out: Path) -> None:
    """Photograph the ghost of an arm that turns, beside the other one."""
    from bench.ros.beside import NODE, VIEWER
    from bench.ros.driver import SCENE
    from bench.ros.processes import Processes

    with tempfile.TemporaryDirectory() as folder, Processes() as processes:
        scene = Path(folder) / 'cell.yaml'
        scene.write_text(Path(SCENE).read_text(encoding='utf-8') + _STOPPABLE, encoding='utf-8')
        processes.start(NODE, scene_file=str(scene), use_joint_states=True)
        processes.start(VIEWER, port=18302, max_distance=0.1)
        with turning_arm():
            browser = opened('http://127.0.0.1:18302/', *_DESK)
            press(browser, 'to-live')
            browser.wait_for(lambda: 'can stop' in browser.text(), 'a rule that is decided')
            photograph(browser, out / 'stopping_ghost.png')
            browser.close()


@contextmanager
def beside(work: Callable[[threading.Event], object]) -> Iterator[None]:
    """Have a thread work meanwhile, until the event that it was given is set."""
    over = threading.Event()
    thread = threading.Thread(target=work, args=(over,))
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def turning_arm() -> Iterator[None]:
    """Publish the values of an arm again and again, always with the same speeds."""
    rclpy.init()
    node = rclpy.create_node('turning_arm')
    publisher = node.create_publisher(JointState, 'joint_states', 10)

    def publish(over: threading.Event) -> None:
        while not over.wait(0.02):
            message = JointState(name=list(_TURNING), velocity=[v for _, v in _TURNING.values()])
            message.position = [q for q, _ in _TURNING.values()]
            message.header.stamp = node.get_clock().now().to_msg()
            publisher.publish(message)

    try:
        with beside(publish):
            yield
    finally:
        node.destroy_node()
        rclpy.shutdown()


def opened(url: str, width: int, height: int) -> Browser:
    """Return a browser of just this size that has drawn a page."""
    browser = Browser('about:blank', width, height)
    browser.send(
        'Emulation.setDeviceMetricsOverride',
        width=width,
        height=height,
        deviceScaleFactor=1,
        mobile=width < _DESK[0] // 2,
    )
    browser.send('Page.navigate', url=url)
    browser.wait_for(lambda: browser.ask(f'!!({_CANVAS})'), 'a picture')
    browser.wait_for(lambda: browser.ask("!!document.querySelector('#pairs tr')"), 'the table')
    time.sleep(_SETTLING)
    return browser


def press(browser: Browser, name: str) -> None:
    """Click on a button by its id."""
    browser.ask(f"document.getElementById('{name}').click()")


def photograph(browser: Browser, path: Path) -> None:
    """Write what a browser shows, once it has drawn it."""
    time.sleep(_SETTLING)
    browser.screenshot(path)
    image = Image.open(path).convert('RGB')
    # Without rounds of k-means, plain grounds get the tint of other colours.
    few = image.quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE)
    few.save(path, optimize=True)
    print(path)


if __name__ == '__main__':
    main()
