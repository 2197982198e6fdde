"""What a certified stop adds to a cycle: two arms, a person of ten capsules, a map of 1e5 cells.

    ./run exec python -m bench.costs.stopping
    ./run exec python -m bench.costs.stopping --cells 10000 --new-map 10

Two Pandas move at up to 0.8 rad/s a joint, the person walks past them, and cells stand around the
cell. One rule for each arm holds it against all else. Each cycle, with 10 ms of sleep in between,
asks whether both arms can still stop. With ``--new-map K`` a sensor changes the map in each Kth
cycle. Milliseconds of processor time of a cycle: mean, median, 90th and 99th percentile and the
longest, with the share of answers that were clear.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from drake_geom_ros.batch import Joints
from drake_geom_ros.geometry import (
    Capsule,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.stopping import (
    Braking,
    RobotState,
    StopCategory,
    StoppingCheck,
    StoppingQuestion,
    robots_of,
)

SCENE = Path(__file__).parents[2] / 'scenes/two_pandas.yaml'
LIMBS = 10
PAUSE = 0.01  # [s]
RESOLUTION = 0.02  # [m] edge of a cell
SPEED, WALK = 0.8, 1.6  # [rad/s], [m/s]


class BusyCell:
    """Two arms, a person and a map."""

    def __init__(self, cells: int, category: StopCategory) -> None:
        self.graph = SceneGraph()
        self.loaded = load_scene(SCENE, self.graph)
        self.joints = Joints.of(self.loaded)
        self._rng = np.random.default_rng(1)
        person = self.graph.RegisterSource('person')
        self.limbs = [
            self.graph.RegisterFrame(person, GeometryFrame(f'limb{k}')) for k in range(LIMBS)
        ]
        self.own = [self._body(person, frame) for frame in self.limbs]
        obstacles = self.graph.RegisterSource('obstacles')
        self.cells_now = self._map(cells)
        instance = GeometryInstance(RigidTransform(), self.cells_now, 'map')
        instance.set_proximity_properties(ProximityProperties())
        self.map = self.graph.RegisterGeometry(
            obstacles, self.graph.model_inspector().world_frame_id(), instance
        )
        self.source, self.cells = obstacles, cells
        self.context = self.graph.CreateDefaultContext()
        self.robots = robots_of(self.joints)
        self.walk(0)
        braking = Braking(decelerations=(4.0,), reaction_time=0.1, category=category)
        questions = [
            StoppingQuestion(braking, self._arm(robot.name), None, 0.03, WALK)
            for robot in self.robots
        ]
        resting = [id.get_value() for key, id in self.loaded.frames.items() if key[0] == 'objects']
        self.check = StoppingCheck(self.context, self.robots, questions, resting=resting)

    def _body(self, source, frame):
        instance = GeometryInstance(RigidTransform(), Capsule(0.08, 0.3), 'body')
        instance.set_proximity_properties(ProximityProperties())
        return self.graph.RegisterGeometry(source, frame, instance)

    def _arm(self, name: str) -> list[int]:
        return [id.get_value() for key, id in self.loaded.geometries.items() if key[0] == name]

    def _map(self, count: int) -> OccupiedCells:
        """Return cells on the floor and on walls around the cell, beyond the arms' reach."""
        points = self._rng.uniform([-3, -3, -0.3], [3, 3, 2.5], (40 * count, 3))
        out = (np.abs(points[:, :2]).max(axis=1) > 1.6) | (points[:, 2] < -0.1)
        places = np.floor(points[out] / RESOLUTION).astype(np.int64)
        cells = np.unique(places, axis=0)
        return OccupiedCells(
            RESOLUTION, RESOLUTION * (cells[self._rng.permutation(len(cells))[:count]] + 0.5)
        )

    def limb_places(self, cycle: int) -> Floats:
        """Return where the limbs (LIMBS, 3) [m] of the person are in a cycle."""
        t, k = 0.01 * cycle, np.arange(LIMBS)
        at = np.array([1.3 + 0.4 * np.sin(0.7 * t), 1.2 * np.sin(0.4 * t), 0.2])
        return np.asarray(at + 0.1 * np.column_stack((np.cos(k), np.sin(k), 1.2 * k)))

    def walk(self, cycle: int) -> None:
        """Pose the person for a cycle."""
        places = zip(self.limbs, self.limb_places(cycle), strict=True)
        poses = {frame: RigidTransform(place) for frame, place in places}
        self.context.UpdateFramePoses(FramePoseVector(poses))

    def change_map(self) -> None:
        """Have the sensor see something else."""
        self.graph.ChangeShape(self.source, self.map, self._map(self.cells), context=self.context)

    def motion(self, cycle: int) -> tuple[Floats, Floats]:
        """Return the values and the speeds of all joints in a cycle."""
        t = 0.01 * cycle + np.linspace(0.0, 3.0, self.joints.count)
        middle = np.clip(0.5 * (self.joints.lower + self.joints.upper), -2.0, 2.0)
        return middle + 0.4 * np.sin(2.0 * t), SPEED * np.cos(2.0 * t)

    def states(self, cycle: int) -> list[RobotState]:
        """Return how the arms move in a cycle, and pose them."""
        q, v = self.motion(cycle)
        ids = [FrameId(int(value)) for value in self.joints.id_values]
        poses = self.joints.poses(q[None])[0]
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(ids, poses))
        states = []
        for arm, robot in zip(self.joints.arms, self.robots, strict=True):
            columns = [self.joints.names.index(name) for name in robot.joint_names]
            states.append(RobotState(arm.X_WB, q[columns], v[columns]))
        return states


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--cells', type=int, default=100_000)
    parser.add_argument('--cycles', type=int, default=600)
    parser.add_argument('--new-map', type=int, default=0)
    options = parser.parse_args()
    for category in (StopCategory.ALONG_PATH, StopCategory.EACH_JOINT):
        cell, spent, clear, looked = BusyCell(options.cells, category), [], [], []
        for cycle in range(options.cycles):
            cell.walk(cycle)
            states = cell.states(cycle)
            if options.new_map and cycle % options.new_map == 0:
                cell.change_map()
            time.sleep(PAUSE)
            begin = time.thread_time()
            stops = cell.check.stops(states, delay=0.01)
            spent.append(1e3 * (time.thread_time() - begin))
            clear += [stop.clear for stop in stops]
            looked += [(stop.pairs, stop.far_pairs, stop.evaluations) for stop in stops]
        times = np.array(spent[20:])
        figures = [times.mean(), *np.quantile(times, [0.5, 0.9, 0.99, 1.0])]
        counts = np.mean(looked, axis=0)
        print(
            f'category {int(category)}, {options.cells} cells: '
            f'{" ".join(f"{x:.2f}" for x in figures)} ms; clear {np.mean(clear):.0%}; '
            f'{counts[0]:.0f} pairs, {counts[1]:.0f} far, {counts[2]:.1f} evaluations'
        )


if __name__ == '__main__':
    main()
