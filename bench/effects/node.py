"""The real node under a rung's stream of poses: what it computes and publishes for whom.

Each case is a node process of its own. Its effects come from ~/cycle_report, its processor time
and memory from the operating system, the number of messages from who receives them.
"""

from __future__ import annotations

import array
import json
import os
import statistics
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from drake_geom_msgs import msg
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from visualization_msgs.msg import MarkerArray

from bench.effects.rungs import FRAMES, POSES, RATE, SCENE
from bench.ros.processes import Processes, memory

NODE, SERVER = 'drake_geom_ros.ros.scene_graph_node', '/scene_graph'
SETTLING = 0.5  # [s] after the stream begins before anything counts
_TICKS = os.sysconf('SC_CLK_TCK')
_TOPICS = {
    'signed_distances': msg.SignedDistancePairs,
    'penetrations': msg.PenetrationPairs,
    'cycle_report': msg.CycleReport,
    'markers': MarkerArray,
}


@dataclass(frozen=True)
class Case:
    """A rung, who listens, and parameters of the node."""

    rung: str
    says: str
    listens: tuple[str, ...] = ()
    parameters: dict[str, object] = field(default_factory=dict)


CASES = (
    Case('two spheres', 'distances', ('signed_distances', 'cycle_report')),
    Case('1000 anchored', 'distances', ('signed_distances', 'cycle_report')),
    Case('two arms', 'nobody listens'),
    Case('two arms', 'only the report', ('cycle_report',)),
    Case('two arms', 'distances', ('signed_distances', 'cycle_report')),
    Case('two arms', 'markers on, nobody looks', (), {'publish_markers': 'true'}),
    Case('two arms', 'markers off, RViz looks', ('markers',)),
    Case('two arms', 'markers on, RViz looks', ('markers',), {'publish_markers': 'true'}),
)


class Watcher:
    """A client: plays poses, counts what comes, keeps the last report."""

    def __init__(self, case: Case) -> None:
        rclpy.init()
        self.node = rclpy.create_node('effects')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self.received: Counter[str] = Counter()
        self.reports: list[Any] = []
        self.scenes: list[Any] = []
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(msg.Scene, f'{SERVER}/scene', self.scenes.append, latched)
        for topic in case.listens:
            self.node.create_subscription(
                _TOPICS[topic], f'{SERVER}/{topic}', self._take_from(topic), 100
            )
        self.poses = self.node.create_publisher(msg.FramePoses, f'{SERVER}/frame_poses', 5)

    def _take_from(self, topic: str) -> Any:
        def take(message: Any) -> None:
            self.received[topic] += 1
            if topic == 'cycle_report':
                self.reports.append(message)

        return take

    def spin(self, until: float) -> None:
        """Serve what comes in until a time of the performance counter."""
        while (left := until - time.perf_counter()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def wait_for_scene(self, patience: float) -> None:
        """Wait until the node is active: it publishes its scene then."""
        end = time.perf_counter() + patience
        while not (self.scenes and self.poses.get_subscription_count()):
            if time.perf_counter() > end:
                raise RuntimeError(f'{SERVER} was not active within {patience:g} s')
            self._executor.spin_once(timeout_sec=0.01)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown()


def play(watcher: Watcher, frames: list[str], poses: Any, count: int) -> None:
    """Send poses at RATE, ``count`` messages."""
    message = msg.FramePoses(frame_names=frames)
    start = time.perf_counter()
    for k in range(count):
        message.poses = array.array('d', np.ascontiguousarray(poses[k % len(poses)]).tobytes())
        watcher.poses.publish(message)
        watcher.spin(start + (k + 1) / RATE)


def processor(pid: int) -> float:
    """Return the processor time that a process has used [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS


def measure(case: Case, folder: Path, seconds: float, patience: float = 300.0) -> dict[str, Any]:
    """Return what the node did in a case; ``folder`` holds the rung."""
    frames = json.loads((folder / FRAMES).read_text())
    poses = np.load(folder / POSES)
    watcher = Watcher(case)
    try:
        with Processes() as processes:
            start = time.perf_counter()
            node = processes.start(NODE, scene_file=folder / SCENE, **case.parameters)
            watcher.wait_for_scene(patience)
            started = time.perf_counter() - start
            play(watcher, frames, poses, round(SETTLING * RATE))
            watcher.received.clear()
            watcher.reports.clear()
            used, sent = processor(node.pid), round(seconds * RATE)
            play(watcher, frames, poses, sent)
            used = processor(node.pid) - used
            resident = memory(node.pid)
    finally:
        watcher.close()
    return {
        'start': started,
        'memory': resident,
        'processor': used / seconds,
        'received': {topic: watcher.received[topic] / seconds for topic in case.listens},
        'effects': told(watcher.reports),
    }


def told(reports: list[Any]) -> dict[str, tuple[float, float, str]]:
    """Return of each effect: median count and seconds of the cycles, and why not, mostly."""
    found: dict[str, list[tuple[float, float, str]]] = {}
    for report in reports:
        columns = (report.effects, report.effect_counts, report.effect_seconds)
        for name, *row in zip(*columns, report.effect_reasons, strict=True):
            found.setdefault(name, []).append(tuple(row))
    return {
        name: (
            statistics.median(row[0] for row in rows),
            statistics.median(row[1] for row in rows),
            Counter(row[2] for row in rows).most_common(1)[0][0],
        )
        for name, rows in found.items()
    }
