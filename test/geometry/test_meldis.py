"""pydrake's own visualiser, in a process of its own, shows what we send."""

import base64
import importlib.util
import os
import re
import socket
import struct
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest
from geometry.visualizer.test_drake_visualizer import SHAPES, scene_of

from drake_geom_ros.geometry import ConnectDrakeVisualizer, FramePoseVector, GeometryError
from drake_geom_ros.geometry.visualizer import drake_visualizer
from drake_geom_ros.math import RigidTransform

PATIENCE = 60.0  # [s]

pytestmark = [
    pytest.mark.processes,
    pytest.mark.everything,
    pytest.mark.skipif(
        any(importlib.util.find_spec(name) is None for name in ('pydrake', 'lcm')),
        reason='pydrake, whose meldis shows it, or the library lcm is not installed',
    ),
]


def free_port():
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))
        return taken.getsockname()[1]


def commands(port):
    """Return what the page of meldis is made of, as bytes; nothing before it is there."""
    try:
        with urllib.request.urlopen(f'http://localhost:{port}/download', timeout=10) as page:
            text = page.read().decode()
    except (urllib.error.URLError, ConnectionError):
        return b''
    return b''.join(
        base64.b64decode(each) for each in re.findall(r'base64,([A-Za-z0-9+/=]+)', text)
    )


def test_all_shapes_appear_and_moves_arrive():
    url = f'udpm://239.255.76.68:{20000 + os.getpid() % 20000}?ttl=0'
    try:
        wire = drake_visualizer.open_lcm(url)
    except GeometryError as error:
        pytest.skip(f'there is no multicast here: {error}')
    port = free_port()
    meldis = subprocess.Popen(
        [sys.executable, '-m', 'pydrake.visualization.meldis', '--port', str(port)],
        env={**os.environ, 'LCM_DEFAULT_URL': url},
        stdout=subprocess.DEVNULL,
    )
    scene, frame, context = scene_of(*SHAPES)
    X_WF = RigidTransform([1234.5, 0.0, 0.0])
    context.UpdateFramePoses(FramePoseVector({frame: X_WF}))
    # Box, floor, and the others as meshcat calls them; the position is a double of msgpack.
    wanted = [b'BoxGeometry', b'SphereGeometry', b'CylinderGeometry', b'robot/link/4']
    wanted.append(b'\xcb' + struct.pack('>d', 1234.5))
    try:
        end = time.monotonic() + PATIENCE
        missing = wanted
        while missing and time.monotonic() < end:
            assert meldis.poll() is None
            ConnectDrakeVisualizer(None, scene, wire).Publish(context, 0.0)
            shown = commands(port)
            missing = [each for each in wanted if each not in shown]
            time.sleep(0.5)
        assert missing == []
    finally:
        meldis.terminate()
        meldis.wait()
