"""Simulate a mobile robot among sensors and a person, and judge whether a stop is ever late.

    python examples/mobile_cell/cell.py [--seconds 600] [--fault NAME] [--picture FILE]

The node's scene is driven without ROS, by simulated stamps, as fast as it goes: odometry and two
publishers of joints at 50 Hz, two lidars at 25 Hz, a depth camera at 5 Hz and a tracker at 25 Hz.
The node's gate passes as much of the base's command as the rules allow and prove. Each step the
referee compares the rules with the distances that the simulation knows, and it sees whether the
robot touches anything while it moves.

A rule is late if a body is nearer than its limit, by more than it can come nearer within one
period of its sensor and by the edge of a cell, and the rule is not entered. Once a sensor has had
a fault for as long as a pose may be old, its rule must be entered, whatever is near.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from types import SimpleNamespace as Plain

import numpy as np
from world import DRIVE, ROLL, WALK, Clock, RobotScene, World, header

from drake_geom_ros.common.progress_bar import progress_bar
from drake_geom_ros.live.conversions.tracked_objects import TrackedObjectsReader
from drake_geom_ros.live.gates import decide_gate
from drake_geom_ros.live.inputs.obstacle_records import ObstacleSettings
from drake_geom_ros.live.inputs.obstacle_sources import age_limits, settings_of
from drake_geom_ros.live.inputs.obstacles import ObstacleInput
from drake_geom_ros.live.inputs.point_taker import PointTaker
from drake_geom_ros.live.inputs.sensor_frames import SensorFrames
from drake_geom_ros.live.inputs.tracked_input import TrackedInput
from drake_geom_ros.live.scene.map_placing import stand_fed
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.live.scene.stops_beside_sensors import Sensed
from drake_geom_ros.live.velocity_gate import VelocityGate
from drake_geom_ros.scene_files import read_scene

STEP = 0.02  # [s]
EVERY = {'front': 2, 'rear': 2, 'camera': 10, 'tracker': 2}  # steps from one message to the next
FAULTS = tuple(f'{name} {what}' for name in EVERY for what in ('dies', 'is late'))
FAULTS += tuple(f'{name} alternates' for name in EVERY)
FAULTS += tuple(f'{name} sees only the robot' for name in ('front', 'rear', 'camera'))
STALE_AFTER, RESOLUTION, LATE = 0.4, 0.05, 0.7  # [s], [m], [s] by which a late sensor is late
NOTICED = 0.7  # [s] from a fault on until its rule must be entered
FASTEST = DRIVE + 0.8  # [m/s] of a point of the robot, its swinging arm included


class Cell:
    """The scene of the node with its sensors, and what the rules say."""

    def __init__(self, clock):
        self.clock = clock
        self.robot = RobotScene('cell.yaml', clock)
        self.live = self.robot.live
        sources = {
            s.name: s for s in read_scene(Path(__file__).parent / 'cell.yaml').obstacle_sources
        }
        settings = ObstacleSettings(
            resolution=RESOLUTION, reach=12.0, padding=0.05, noise=0.02, self_filter='robots',
            least_points=1, keep=0.0, rays=False, margin=0.0,
        )  # fmt: skip
        frames = SensorFrames(lambda: None)
        self.inputs = {
            name: ObstacleInput(
                source, self.live, partial(settings_of, source, settings), frames, lambda: None
            )
            for name, source in sources.items()
        }
        self.live.map_sources = MapSources(self.inputs)
        with self.live.editing() as scene:
            scene.poses.history = PoseHistory()
            scene.maps.stand = partial(stand_fed, sources=self.live.map_sources)
            scene.maps.limits = age_limits(sources)
            scene.maps.stand(scene)
        self.takers = {name: PointTaker(each) for name, each in self.inputs.items()}
        self.tracked = TrackedInput(self.live, frames)
        self.reader = TrackedObjectsReader()
        self.refused = 0
        self.passed = np.zeros(6)  # what the gate let through last
        self.gate = VelocityGate(self._pass, timeout=0.5)
        self.gate.open()
        with self.live.editing() as scene:
            scene.poses.watch_motion(1.0)

    def _pass(self, twist, header):
        self.passed = twist

    def hear(self, name, message, publisher='1'):
        """Take a message of a sensor or of the tracker; one that is refused changes nothing."""
        try:
            if name == 'tracker':
                bodies = self.reader.read(message, self.live.files)
                self.tracked.take(bodies, 0.0, publisher)
            elif name == 'camera':
                picture, info = message
                self.takers[name].take_camera(info, 0.0, publisher)
                self.takers[name].take_depth(picture, 0.0, publisher)
            else:
                self.takers[name].take_scan(message, 0.0, publisher)
        except RuntimeError:
            self.refused += 1

    def decide(self, command):
        """Return which rules are entered, and why; the gate takes a command (6,) meanwhile."""
        self.tracked.sweep()
        with self.live.editing() as scene:
            scene.bind_rules()
            blind, twists = scene.blind_frames(STALE_AFTER), scene.poses.twists()
            sensed = Sensed(scene.maps.shells(), scene.maps.sights())
            scene.rules.decide(
                self.clock.now,
                scene.query,
                blind,
                twists=twists,
                shells=sensed.shells,
                sights=sensed.sights,
                stops=scene.stopping.stops(twists, STALE_AFTER, STEP, sensed),
            )
            self.gate.take(command, self.clock.now)
            decide_gate(scene, 'mobile', self.gate, self.clock.now)
            return {s.rule.name: s.why for s in scene.rules.states() if s.is_entered}


def tracked_message(now, bodies):
    """Return the TrackedObjects of a tracker."""
    shape = Plain(type=4, dimensions=[0.25, 1.8], mesh_uri='', vertices=[], triangles=[])
    rows = [value for p in bodies.values() for value in (*map(float, p), 0.0, 0.0, 0.0, 1.0)]
    count = len(bodies)
    return Plain(
        header=header(now), names=list(bodies), shapes=[shape] * count, poses=rows,
        velocities=[], lifetimes=[0.3] * count,
    )  # fmt: skip


def ignore(decisions):
    """Show no progress."""


class Run:
    """One run of the simulation with a referee.

    ``late`` are the moments of late stops, ``touched`` those at which the robot touched something
    while it moved.
    """

    def __init__(self, fault='', seed=0):
        self.clock = Clock()
        self.world, self.cell = World(self.clock, seed), Cell(self.clock)
        self.fault = fault
        self._waiting = []  # late messages: when they come, whose, what
        self.steps, self.stopped, self.true_stops = 0, 0, 0
        self.late, self.touched, self.whys = [], [], []
        self.gone = 0.0  # [s] of motion at the nominal speed
        self.fault_since = math.inf  # [s] of the simulated time
        self.tail = []  # for the picture: time, distances, rules

    def _measure(self, name):
        if name == 'tracker':
            return tracked_message(self.clock.now, self.world.seen_by_tracker())
        return self.world.depth() if name == 'camera' else self.world.scan(f'{name}_lidar')

    def _sense(self, *, has_fault):
        """Let each sensor whose turn it is measure and speak, as its fault lets it."""
        for name, every in EVERY.items():
            if self.steps % every:
                continue
            has = has_fault and self.fault.startswith(f'{name} ')
            what = self.fault.removeprefix(f'{name} ')
            if has and what == 'dies':
                continue
            message = self._measure(name)
            if has and what == 'is late':
                self._waiting.append((self.clock.now + LATE, name, message))
            elif has and what == 'sees only the robot' and name == 'camera':
                self.cell.hear(name, self.world.depth(self.cell.robot))
            elif has and what == 'sees only the robot':
                message.ranges = np.full(len(message.ranges), 0.06)
                self.cell.hear(name, message)
            else:
                turn = self.steps // every % 2 if has and what == 'alternates' else 0
                self.cell.hear(name, message, f'{1 + turn}')
        due = [each for each in self._waiting if each[0] <= self.clock.now]
        self._waiting = [each for each in self._waiting if each[0] > self.clock.now]
        for _, name, message in due:
            self.cell.hear(name, message)

    def go(self, seconds, fault_at=math.inf, progress=ignore):
        """Simulate some time; from ``fault_at`` [s] on a sensor has its fault.

        ``progress`` is called with the number of decisions after each one.
        """
        begin, share = self.clock.now, 0.0
        self.fault_since = begin + fault_at
        while self.clock.now - begin < seconds - 0.5 * STEP:
            self.clock.now += STEP
            self.world.move(share=share, seconds=STEP)
            rates = [self.world.share * rate for rate in self.world.arm_rates]
            self.cell.robot.pose(self.clock.now, self.world.row, *self.world.arm, rates)
            if not self.steps:
                self.cell.robot.carry()
            self._sense(has_fault=self.clock.now >= self.fault_since)
            command = self.world.command
            entered = self.cell.decide(command)
            share = float(np.linalg.norm(self.cell.passed) / np.linalg.norm(command))
            self.steps += 1
            self.stopped += self.world.share == 0.0
            self.gone += self.world.share * STEP
            self.whys.append(entered)
            self._judge(entered)
            progress(self.steps)
        return self

    def _judge(self, entered):
        """Compare the rules with the truth."""
        distances = self.world.distances()
        self.tail.append((self.clock.now, distances, sorted(entered)))
        if self.world.share > 0.0 and min(distances.values()) <= 0.0:
            self.touched.append(round(self.clock.now, 3))
        tracked = 'person' in self.world.seen_by_tracker()
        period = {name: every * STEP for name, every in EVERY.items()}
        limits = {
            'person': 0.6 - (WALK + FASTEST) * period['tracker'] if tracked else 0.0,
            'obstacle': 0.5 - (ROLL + FASTEST) * period['front'] - RESOLUTION,
        }
        nearest = {'person': distances['person'], 'obstacle': distances['trolley']}
        since_fault = self.clock.now - self.fault_since
        # Two drivers of one sensor show the same in turn: nothing is to be late for that.
        is_harmless = self.fault in ('front alternates', 'rear alternates', 'camera alternates')
        if since_fault >= 0.0 and not is_harmless:
            rule = 'person' if self.fault.startswith('tracker') else 'obstacle'
            limits[rule] = math.inf if since_fault > NOTICED else 0.0
        for rule, limit in limits.items():
            if nearest[rule] < limit:
                self.true_stops += 1
                if rule not in entered:
                    self.late.append((round(self.clock.now, 3), rule, nearest[rule]))


def draw(run, file):
    """Draw the distances that the simulation knows, and when the rules were entered."""
    import matplotlib

    matplotlib.use('Agg')
    from matplotlib import pyplot

    times = np.array([time for time, _, _ in run.tail]) - run.tail[0][0]
    figure, axes = pyplot.subplots(2, 1, sharex=True, figsize=(9, 5), layout='constrained')
    of_rules = ('person', 'person', 0.6), ('obstacle', 'trolley', 0.5)
    for axis, (rule, body, limit) in zip(axes, of_rules, strict=True):
        axis.plot(times, [d[body] for _, d, _ in run.tail], label=f'true distance to the {body}')
        entered = [rule in rules for _, _, rules in run.tail]
        axis.fill_between(times, 0.0, 3.0, where=entered, alpha=0.2, step='post', label='stop')
        axis.axhline(limit, linestyle='--', color='grey', label='limit of the rule')
        axis.set(ylim=(0.0, 3.0), ylabel='[m]')
        axis.legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncol=3, frameon=False)
    axes[-1].set_xlabel('simulated time [s]')
    figure.savefig(file, dpi=110)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, and print what the referee saw; 1 if a stop was late or the robot touched anything."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--seconds', type=float, default=600.0, help='of simulated time')
    parser.add_argument('--fault', choices=FAULTS, default='', help='from the middle on')
    parser.add_argument('--seed', type=int, default=0, help='of the walk of the person')
    parser.add_argument('--picture', type=Path, help='file to draw')
    options = parser.parse_args(arguments)
    fault_at = 0.5 * options.seconds if options.fault else math.inf
    if options.picture:
        options.picture.parent.mkdir(parents=True, exist_ok=True)
    run = Run(options.fault, options.seed)
    steps, silent = round(options.seconds / STEP), nullcontext(ignore)
    with progress_bar('decisions', steps) if sys.stderr.isatty() else silent as show:
        run.go(options.seconds, fault_at, show)
    print(f'{run.steps} decisions in {options.seconds:g} s, stopped in {run.stopped}')
    print(f'motion {run.gone / options.seconds:.0%}; touched while moving: {len(run.touched)}')
    print(f'a body was nearer than its limit in {run.true_stops}; late: {len(run.late)}')
    for time, rule, distance in run.late[:5]:
        print(f'  at {time} s {rule}: {distance:.3f} m')
    if options.picture:
        draw(run, options.picture)
    return int(bool(run.late or run.touched))


if __name__ == '__main__':
    raise SystemExit(main())
