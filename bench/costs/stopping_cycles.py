"""What stoppable rules add to a cycle of a live scene: arms, a person of ten capsules, a map.

    ./run exec python -m bench.costs.stopping_cycles

The workload is that of ``bench.costs.stopping``, through the live scene of a node: joint values
with velocities and stamped poses come, and the rules of both arms are decided, published to topics
that only keep the messages, and counted. Two scenes take turns, one without rules. Milliseconds of
processor time of a cycle without and with rules, and of their difference in the same cycle: mean,
median, 90th and 99th percentile and the longest.
"""

from __future__ import annotations

import argparse
import math
import time
from types import SimpleNamespace as Plain

import numpy as np
import yaml
from drake_geom_msgs import msg
from live.live_scenes import Clock, Topic, live_scene
from ros.scene_calls import poses
from std_msgs.msg import Float64

from bench.costs.stopping import LIMBS, PAUSE, SCENE, WALK, BusyCell
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.outputs.rule_events import (
    RuleEvents,
    RuleMessages,
    RuleSettings,
    RuleTopics,
)
from drake_geom_ros.scene_files.sensed_shapes import plain_map
from drake_geom_ros.stopping import StopCategory

CYCLE = 0.01  # [s]
_LAST = 1  # messages of a topic that are kept


class _Kept(Topic):
    """A topic with a subscriber that keeps the last message."""

    def publish(self, message) -> None:
        super().publish(message)
        del self.published[:-_LAST]


class LiveCell:
    """The busy cell in a live scene, with or without its rules."""

    def __init__(self, cell: BusyCell, category: StopCategory, *, with_rules: bool) -> None:
        self.clock, self._cell = Clock(1000.0), cell
        self.live = live_scene(_text(cell, category, with_rules), self.clock)
        self._joints = JointInput(self.live.clocks, 1.0, by_default=True)
        types = RuleMessages(
            msg.ProximityEvents,
            msg.ProximityRules,
            msg.ProximityStates,
            msg.SpeedLimits,
            msg.Stopping,
            Float64,
        )
        self.topics = RuleTopics(*(_Kept() for _ in range(5)))
        self._events = RuleEvents(
            self.topics, types, lambda: RuleSettings(1.0), lambda pairs, seconds: None
        )

    def cycle(self, number: int) -> float:
        """Take the inputs of a cycle and decide; return the milliseconds of the processor."""
        self.clock.now += CYCLE
        now = math.floor(self.clock.now), round(math.fmod(self.clock.now, 1.0) * 1e9)
        stamp = Plain(sec=now[0], nanosec=now[1])
        q, v = self._cell.motion(number)
        state = Plain(
            header=Plain(stamp=stamp, frame_id=''),
            name=list(self._cell.joints.names),
            position=q.tolist(),
            velocity=v.tolist(),
            effort=[],
        )
        names = [f'limb{k}' for k in range(LIMBS)]
        person = poses(names, self._cell.limb_places(number), source='person')
        time.sleep(PAUSE)
        begin = time.thread_time()
        with self.live.editing() as scene:
            self._joints.take(scene, state, 0.0)
            scene.poses.take(person)
            self._events.look_at(scene, None, 0.0)
        return 1e3 * (time.thread_time() - begin)


def _text(cell: BusyCell, category: StopCategory, with_rules: bool) -> str:
    """Return the scene file of the cell."""
    plain = yaml.safe_load(SCENE.read_text())
    plain['sources'] += ['person', 'obstacles']
    plain.pop('cameras')
    for k, place in enumerate(cell.limb_places(0)):
        pose = {'position': place.tolist()}
        plain['frames'].append({'name': f'limb{k}', 'source': 'person', 'pose': pose})
        shape = {'type': 'capsule', 'radius': 0.08, 'length': 0.3}
        plain['geometries'].append(
            {'name': 'body', 'source': 'person', 'frame': f'limb{k}', 'shape': shape}
        )
    cells = {'name': 'map', 'source': 'obstacles', 'shape': plain_map(cell.cells_now)}
    plain['geometries'].append(cells)
    rule = {
        'level': 'stoppable',
        'decelerations': 4.0,
        'reaction_time': 0.1,
        'stop_category': int(category),
        'margin': 0.03,
        'max_speed': WALK,
    }
    arms = ('left', 'right') if with_rules else ()
    plain['proximity_rules'] = [{'name': arm, 'set_a': arm, **rule} for arm in arms]
    return str(yaml.safe_dump(plain))


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--cells', type=int, default=100_000)
    parser.add_argument('--cycles', type=int, default=600)
    options = parser.parse_args()
    for category in (StopCategory.ALONG_PATH, StopCategory.EACH_JOINT):
        cell = BusyCell(options.cells, category)
        both = [LiveCell(cell, category, with_rules=rules) for rules in (False, True)]
        spent = np.array([[live.cycle(k) for live in both] for k in range(options.cycles)])[20:]
        scales = both[1].topics.stopping.published[-1].scale
        print(f'category {int(category)}, {options.cells} cells, scales at last {list(scales)}')
        for name, times in (
            ('without rules', spent[:, 0]),
            ('with rules', spent[:, 1]),
            ('difference', spent[:, 1] - spent[:, 0]),
        ):
            figures = [times.mean(), *np.quantile(times, [0.5, 0.9, 0.99, 1.0])]
            print(f'  {name}: {" ".join(f"{x:.2f}" for x in figures)} ms')


if __name__ == '__main__':
    main()
