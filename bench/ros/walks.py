"""How often a message, or a request, goes from file to file of the package on its way.

    ./run exec python -m bench.ros.walks

The path of a reader who follows one message: a stay is a run of calls within one file, a return is
a stay in a file that was seen before. Counted by ``sys.setprofile``, for a message like those
before it: names are looked up and kernels compiled by then.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any, NamedTuple

from drake_geom_msgs import msg, srv
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

import drake_geom_ros
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.outputs.contact_topic import ContactTopic
from drake_geom_ros.live.outputs.cycle import Cycle
from drake_geom_ros.live.outputs.level_costs import LevelCosts
from drake_geom_ros.live.outputs.replays import Replays
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.services import filters, motions
from drake_geom_ros.scene_files import read_scene

PACKAGE = str(Path(drake_geom_ros.__file__).parent)
SCENES = Path(__file__).parents[2] / 'scenes'
BEFORE = 5  # messages before the one that is counted


class Walk(NamedTuple):
    """The files of the package that something passes, in order."""

    stays: list[str]

    @property
    def files(self) -> int:
        """Number of different files."""
        return len(set(self.stays))

    @property
    def returns(self) -> int:
        """Number of stays in files that were seen before."""
        return len(self.stays) - self.files


def walked(task: Callable[[], object]) -> Walk:
    """Do something, and return its walk."""
    stays: list[str] = []

    def note(frame: FrameType, event: str, _: Any) -> None:
        name = frame.f_code.co_filename
        if event == 'call' and name.startswith(PACKAGE) and stays[-1:] != [name]:
            stays.append(name)

    sys.setprofile(note)
    try:
        task()
    finally:
        sys.setprofile(None)
    return Walk(stays)


class _Publisher:
    """A publisher with one subscriber."""

    def get_subscription_count(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        pass


class _Results(_Publisher):
    """A publisher that makes what it publishes."""

    def __init__(self, kind: Any) -> None:
        self.make_message = kind


class _Node:
    """What a node has for a scene: the stream of poses and its cycle, with results listened to."""

    def __init__(self, scene_file: str) -> None:
        self.live = LiveScene('exact', Clocks(time.time))
        with self.live.editing() as scene:
            scene.make(addition(read_scene(SCENES / scene_file)))
        kinds = {'penetrations': msg.PenetrationPairs, 'signed_distances': msg.SignedDistancePairs}
        results = {name: _Results(kind) for name, kind in kinds.items()}
        silent = SimpleNamespace(get_subscription_count=lambda: 0, make_message=msg.CycleReport)
        publishers = {**results, 'cycle_report': silent}
        topics = RuleTopics(*(_Publisher() for _ in RuleTopics._fields))
        types = SimpleNamespace(**vars(msg), Float64=Float64)
        rules = RuleEvents(topics, types, lambda: RuleSettings(1.0), lambda *_: None)
        contacts = ContactTopic(
            silent, msg.ContactSurfaces, lambda: False, lambda: False, lambda _: None
        )
        costs, replays = LevelCosts(self.live, silent), Replays(lambda: ('', 20))
        cycle = Cycle(publishers, costs, replays, rules, contacts)
        values = SimpleNamespace(stale_after=1.0, rate=0.0, max_distance=0.3, time_budget=0.0)
        counts = SimpleNamespace(take=lambda *_: None, answer=lambda _: None)
        self.stream = PoseStream(self.live, SimpleNamespace(values=values), counts, cycle)
        self.stream.active = True
        self.stream.inputs.joints = JointInput(self.live.clocks, 1.0, by_default=True)
        logger = SimpleNamespace(warning=_refused, error=_refused, info=print)
        self.guard = Guard(logger, lambda *_: None)


def _refused(text: str) -> None:
    raise AssertionError(text)  # the walk of a refusal is another one


def _stamped(message: Any) -> Any:
    now = time.time_ns()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
    return message


def _pose_message(node: _Node) -> None:
    x = 0.5 + 1e-3 * (time.monotonic() % 1.0)
    message = msg.FramePoses(frame_names=['ball'], poses=[x, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0])
    node.guard.take('frame_poses', node.stream.take_poses, _stamped(message), 0.0, 'sender')


def _joint_states(node: _Node) -> None:
    names = [f'{arm}::panda_joint{k}' for arm in ('left', 'right') for k in range(1, 8)]
    bend = 1e-3 * (time.monotonic() % 1.0)
    message = JointState(name=names, position=[0.0, bend, 0.0, -1.5, 0.0, 1.5, 0.7] * 2)
    take = node.stream.take_joint_states
    node.guard.take('joint_states', take, '', _stamped(message), 0.0, 'sender')


def _check_motion(node: _Node) -> None:
    request = srv.CheckMotion.Request()
    names = ['left::panda_joint1']
    request.path.joint_names = names
    request.path.points = [_point(0.0), _point(0.2)]
    response = srv.CheckMotion.Response()
    node.guard.answer(motions.check_motion, node.live, request, response)
    assert response.success, response.message


def _point(value: float) -> Any:
    from trajectory_msgs.msg import JointTrajectoryPoint

    return JointTrajectoryPoint(positions=[value])


def _filter_request(node: _Node) -> None:
    kind = srv.ApplyTransientFilter
    request, response = kind.Request(), kind.Response()
    sets = msg.GeometrySet(frames=['ball']), msg.GeometrySet(geometries=['world/floor'])
    statement = msg.CollisionFilterStatement(operation=2, set_a=sets[0], set_b=sets[1])
    request.declaration.statements = [statement]
    node.guard.answer(filters.apply_transient_filter, node.live, request, response)
    assert response.success, response.message


WALKS = (
    ('a pose message', 'minimal.yaml', _pose_message),
    ('joint states of two arms', 'two_pandas.yaml', _joint_states),
    ('check_motion', 'two_pandas.yaml', _check_motion),
    ('a filter request', 'minimal.yaml', _filter_request),
)


def main() -> None:
    """Print the walks of all."""
    print(f'{"":26}{"stays":>8}{"files":>8}{"returns":>9}')
    for title, scene, task in WALKS:
        node = _Node(scene)
        for _ in range(BEFORE):
            task(node)
        walk = walked(lambda task=task, node=node: task(node))  # type: ignore[misc]
        print(f'{title:26}{len(walk.stays):8}{walk.files:8}{walk.returns:9}')
        if '--files' in sys.argv:
            for name in walk.stays:
                print(f'    {name[len(PACKAGE) + 1 :]}')


if __name__ == '__main__':
    main()
