"""Real ROS 2 in tests: the node in a process of its own, a client that waits for facts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from drake_geom_msgs import srv
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros.forked_program import ForkedProgram

from drake_geom_ros.common.children import end

ROOT = Path(__file__).resolve().parents[2]
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
# A fact that has not come by then [s] will not come: a node may have to compile its kernels first,
# on a busy machine, and pytest ends a test soon after.
PATIENCE = 240.0
ANSWER_PATIENCE = 10.0  # [s] an answer that has not come by then may be lost


def environment():
    """Return the environment of every ROS process of the tests: this machine, own domain."""
    domain = os.environ.get('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    paths = [str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])]
    return {
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        **os.environ,
        'ROS_DOMAIN_ID': domain,
        'PYTHONPATH': os.pathsep.join(paths),
        'PYTHONUNBUFFERED': '1',
        'PYTHONFAULTHANDLER': '1',  # a crash writes the stacks of all threads into the log
    }


def without_shared_memory(monkeypatch):
    """Let processes that are started now use Fast DDS by the profile, as ``run`` does."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SYSTEM_DEFAULT')
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', str(ROOT / 'config/fastdds.xml'))
    monkeypatch.setenv('RMW_FASTRTPS_USE_QOS_FROM_XML', '1')


def run_python(*arguments, timeout=800):
    """Return what became of Python with arguments, in the environment of the tests."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        env=environment(),
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


class Process:
    """A Python module, or one of our programs by the path of its script, run as a process.

    Its output is in a file, and it is ended by its own pid. A program is forked from a process
    that has imported everything, unless it is to start ``anew``.
    """

    def __init__(
        self, log: Path, started: str | Path, *arguments: str, anew: bool = False
    ) -> None:
        self.log = log
        self._forgotten = 0  # characters of the log
        self.popen: subprocess.Popen[bytes] | ForkedProgram
        if isinstance(started, Path) and not anew:
            self.popen = ForkedProgram(started.name, arguments, environment(), log)
            return
        how = [started] if isinstance(started, Path) else ['-m', started]
        with log.open('w') as output:
            self.popen = subprocess.Popen(
                [sys.executable, *how, *arguments],
                env=environment(),
                cwd=ROOT,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    def output(self) -> str:
        return self.log.read_text()[self._forgotten :]

    def forget_output(self) -> None:
        """Leave what is in the log out of the output."""
        self._forgotten = len(self.log.read_text())

    def end(self, signal_number=signal.SIGINT) -> int:
        """Ask the process to end, wait, and return its exit code.

        One that compiles ends once it has: on a busy machine more than 20 s later.
        """
        return end(self.popen, 60.0, signal_number)


def start_node(
    log: Path,
    *,
    namespace: str = '',
    name: str = '',
    remap: tuple[str, ...] = (),
    enclave: str = '/',
    anew: bool = False,
    **parameters,
) -> Process:
    """Start scene_graph_node with parameters, and remappings as ``from:=to``."""
    arguments = ['--ros-args', '--enclave', enclave]
    rules = [*remap, f'__ns:={namespace}' * bool(namespace), f'__node:={name}' * bool(name)]
    for rule in filter(None, rules):
        arguments += ['-r', rule]
    for parameter, value in parameters.items():
        text = str(value).lower() if isinstance(value, bool) else str(value)
        arguments += ['-p', f'{parameter}:={text}']
    return Process(log, ROOT / 'scripts/scene_graph_node', *arguments, anew=anew)


def wait_until_ready(client) -> None:
    """Wait until the server of a client answers: what is started then need not be so patient."""
    assert client.call(srv.HasCollisions, 'has_collisions').success


class Client:
    """A node of the test: calls services, listens, publishes; every wait has an end."""

    def __init__(self, server: str = '/scene_graph') -> None:
        env = environment()
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = env['ROS_AUTOMATIC_DISCOVERY_RANGE']
        self.server = server
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=int(env['ROS_DOMAIN_ID']))
        self.node = rclpy.create_node(f'client_{time.monotonic_ns()}', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients = {}
        self._own = [*self.node.publishers, *self.node.subscriptions]

    def close(self) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def serve_by(self, executor) -> None:
        """Have another executor serve the node's callbacks."""
        self._executor.shutdown()
        self._executor = executor

    def forget_topics(self) -> None:
        """Close what a test listened to and published on; the services that it found stay."""
        for subscription in set(self.node.subscriptions).difference(self._own):
            self.node.destroy_subscription(subscription)
        for publisher in set(self.node.publishers).difference(self._own):
            self.node.destroy_publisher(publisher)

    def wait_for(self, fact, what: str, patience: float = PATIENCE):
        """Spin until ``fact()`` is truthy and return it; fail with ``what`` otherwise."""
        end = time.monotonic() + patience
        while time.monotonic() < end:
            if found := fact():
                return found
            self._executor.spin_once(timeout_sec=0.05)
        raise AssertionError(f'waited {patience:g} s for {what}')

    def spin_until(self, moment: float) -> None:
        """Serve callbacks until a moment of the monotonic clock."""
        while (left := moment - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def listen(self, message_class, topic: str, qos=10) -> list:
        """Subscribe and return the list that messages are appended to."""
        messages = []
        name = topic if topic.startswith('/') else f'{self.server}/{topic}'
        self.node.create_subscription(message_class, name, messages.append, qos)
        return messages

    def publisher(self, message_class, topic: str, qos=SENSOR):
        """Return a publisher that knows a listener.

        That one may not know the publisher yet: what is sent by best effort at once may be lost.
        """
        publisher = self.node.create_publisher(message_class, f'{self.server}/{topic}', qos)
        self.wait_for(lambda: publisher.get_subscription_count() > 0, f'a listener to {topic}')
        return publisher

    def call(self, service_class, name: str, /, **fields):
        """Call a service of the server and return its answer."""
        if name not in self._clients:
            client = self.node.create_client(service_class, f'{self.server}/{name}')
            self._clients[name] = client
        client = self._clients[name]
        self.wait_for(client.service_is_ready, f'the service {name}')
        # A server may take a request before it has found who asks, and then its answer is lost
        # (a known race of discovery over DDS, seen where a node opens its services anew): the call
        # is made again. An answer may be late, too, as while the server compiles: the first one
        # counts, for the second call may be refused what the first one did.
        futures, again = [], 0.0

        def answered():
            nonlocal again
            if time.monotonic() > again:
                futures.append(client.call_async(service_class.Request(**fields)))
                again = time.monotonic() + ANSWER_PATIENCE
            return next((future for future in futures if future.done()), None)

        return self.wait_for(answered, f'an answer of {name}').result()
