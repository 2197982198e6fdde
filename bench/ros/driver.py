"""The soak's own process: callers, hostile messages, what the node says of itself."""

from __future__ import annotations

import subprocess
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from rclpy.executors import SingleThreadedExecutor

from bench.ros.faults.inputs import HAS_TF
from bench.ros.faults.site import NODE, PATIENCE
from bench.ros.hostile import pose_messages
from bench.ros.mix import MixedClient, Tally, open_services
from bench.ros.processes import ROOT, Processes

SERVER = '/scene_graph'
PLAYER = 'drake_geom_ros.ros.pose_player'
SCENE, MOTION = ROOT / 'scenes/two_pandas.yaml', ROOT / 'scenes/two_pandas_motion.yaml'
QUIET = ('--ros-args', '--log-level', 'warn')  # each transient filter is told of otherwise
CALL_PERIOD = 0.1  # [s] between two calls of a caller, if the first was answered
HOSTILE_PERIOD = 0.2  # [s] between two hostile messages


@dataclass
class Soak:
    """What happened so far."""

    tally: Tally = field(default_factory=Tally)
    hostile: int = 0
    player_lives: int = 1
    faults: Counter[str] = field(default_factory=Counter)
    memory: list[tuple[float, float]] = field(default_factory=list)  # [s], [MB]
    status: dict[str, str] = field(default_factory=dict)


class Driver:
    """The node of this process: callers, hostile messages, diagnostics."""

    def __init__(self, soak: Soak, callers: int, seed: int) -> None:
        self._soak = soak
        rclpy.init()
        self.node = rclpy.create_node('soak')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        services = open_services(self.node, SERVER)
        self.callers = [
            MixedClient(services, f'caller_{k}', seed + k, soak.tally) for k in range(callers)
        ]
        frames = ['objects::can', 'objects::cube']
        self._messages = [message for _, message, _ in pose_messages(frames, 'objects')]
        self._poses = self.node.create_publisher(msg.FramePoses, f'{SERVER}/frame_poses', 5)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._take_status, 10)
        self.node.create_timer(HOSTILE_PERIOD, self._send_hostile)
        self.node.create_timer(CALL_PERIOD, self._call)
        self._save = services['save_scene']
        self._paused = False

    def _call(self) -> None:
        for caller in self.callers:
            if not self._paused:
                caller.tick()

    def pause(self, paused: bool) -> None:
        """Keep the callers from calling, once their calls are answered; or let them go on."""
        self._paused = paused
        end = time.monotonic() + PATIENCE
        while paused and not all(caller.is_answered() for caller in self.callers):
            if time.monotonic() > end:
                raise TimeoutError(f'callers waited {PATIENCE:g} s for answers')
            self.spin(CALL_PERIOD)

    def _send_hostile(self) -> None:
        self._poses.publish(self._messages[self._soak.hostile % len(self._messages)])
        self._soak.hostile += 1

    def _take_status(self, message: DiagnosticArray) -> None:
        if message.status[0].name == SERVER:
            self._soak.status = {v.key: v.value for v in message.status[0].values}

    def spin(self, seconds: float) -> None:
        """Serve what comes in for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def save(self, path: Path) -> str:
        """Let the node save its scene; return the text."""
        future = self._save.call_async(srv.SaveScene.Request(path=str(path)))
        self._executor.spin_until_future_complete(future, 60.0)
        if not future.done() or not future.result().success:
            raise RuntimeError(f'the scene was not saved: {future.result()}')
        return future.result().text


def start_node(processes: Processes, folder: Path) -> subprocess.Popen[str]:
    """Start the node with the two arms; it may open files in a folder."""
    parameters = {'mesh_roots': f'["package://", "{folder}"]', 'use_tf': str(HAS_TF).lower()}
    return processes.start(NODE, *QUIET, scene_file=SCENE, max_distance=0.1, **parameters)


def start_player(processes: Processes, rate: float) -> subprocess.Popen[str]:
    """Start the player of the two arms."""
    files = {'scene_file': SCENE, 'trajectory_file': MOTION}
    return processes.start(PLAYER, **files, rate=float(rate))
