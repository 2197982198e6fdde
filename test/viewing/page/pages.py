"""Pages on servers of this process."""

import contextlib
import time

import pytest
from viewing.scenes import local_scene

PATIENCE = 100.0  # [s] of a busy machine

TEXT = """
sources: [s, t]
frames:
  - {name: a, source: s, pose: {position: [1, 0, 0]}}
  - {name: b, source: t, pose: {position: [1, 0.5, 0]}}
geometries:
  - {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -0.4]}}
  - {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.2}}
  - {name: pen, source: t, frame: b, shape: {type: capsule, radius: 0.1, length: 0.4}}
  - {name: seen, source: t, frame: b, shape: {type: box, size: [0.1, 0.2, 0.3]},
     roles: {illustration: {}}}
"""


@contextlib.contextmanager
def page_of(scene, host='127.0.0.1', **options):
    """Open a page of a scene at a free port, and close it."""
    pytest.importorskip('viser', reason='draws the page')
    from drake_geom_ros.viewing.page.page import Page
    from drake_geom_ros.viewing.page.serving import open_server

    scene = local_scene(scene) if isinstance(scene, str) else scene
    page = Page(open_server(host, 18080), scene, **{'max_distance': 1.0, **options})
    try:
        wait_for(lambda: page.moment is not None, 'the first picture')
        yield page, scene
    finally:
        page.close()


def wait_for(fact, what):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if found := fact():
            return found
        time.sleep(0.01)
    raise AssertionError(f'waited {PATIENCE:g} s for {what}')


def do(page, name, /, **arguments):
    """Carry out a command as a browser sends it; return the sections for that browser."""
    from drake_geom_ros.viewing.page.commands import Commands

    return Commands(page).execute('test', {'do': name, **arguments})


def value(page, name):
    """Return the id value of a geometry of a page's scene."""
    return next(v for v, each in page.moment.geometries.names.items() if each == name)
