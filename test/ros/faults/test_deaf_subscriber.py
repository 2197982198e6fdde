"""A subscriber that never reads: the stream goes on for the others, and nothing piles up."""

import subprocess
import sys

import pytest
from drake_geom_msgs import msg
from ros.harness import ROOT, Process, environment, start_node

from bench.ros.processes import memory

pytestmark = pytest.mark.topics

SCENE = ROOT / 'scenes/minimal.yaml'
DEAF = """
import time
import rclpy
from drake_geom_msgs.msg import PenetrationPairs, SignedDistancePairs
rclpy.init()
node = rclpy.create_node('deaf')
for kind, name in (SignedDistancePairs, 'signed_distances'), (PenetrationPairs, 'penetrations'):
    node.create_subscription(kind, f'/scene_graph/{name}', print, 10)
print('deaf', flush=True)
time.sleep(600)
"""
MOST_GROWTH = 5.0  # [MB] over 600 cycles whose messages hold 1 kB each


def test_nobody_waits_for_it(tmp_path, lone_client):
    node = start_node(tmp_path / 'node', scene_file=SCENE, max_distance=1.0)
    player = Process(
        tmp_path / 'player',
        ROOT / 'scripts/pose_player',
        *('--ros-args', '-p', f'scene_file:={SCENE}', '-p', 'rate:=200.0'),
    )
    deaf = subprocess.Popen(
        [sys.executable, '-c', DEAF], env=environment(), stdout=subprocess.PIPE, text=True
    )
    try:
        assert deaf.stdout.readline() == 'deaf\n'
        results = lone_client.listen(msg.SignedDistancePairs, 'signed_distances')
        lone_client.wait_for(lambda: len(results) > 100, 'results')
        before = memory(node.popen.pid)
        lone_client.wait_for(lambda: len(results) > 700, 'six hundred more')
        assert memory(node.popen.pid) - before < MOST_GROWTH
        assert deaf.poll() is None
    finally:
        deaf.kill()
        deaf.wait()
        deaf.stdout.close()
        player.end()
        assert node.end() == 0, node.output()
