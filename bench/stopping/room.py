"""A room with an arm, a base, and people who walk at random."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import FrameId, FramePoseVector, SceneGraph
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import load_scene

HERE = Path(__file__).parent
PEOPLE = 2
WALKS = 1.6  # [m/s] at most
HALF = 3.5  # [m] of the room's sides
_BLOCK = 20_000  # states that are judged at once
_ROOM = """
name: room
sources: [people]
robots:
- {{name: arm, urdf: {folder}/arm.urdf, pose: {{position: [0, 1.2, 0]}}}}
- {{name: base, urdf: {folder}/base.urdf}}
frames:
{frames}
geometries:
{bodies}
"""
ROBOTS = ('arm', 'base')


class People:
    """People who walk straight for a while, at any speed and into any direction, and turn."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self.places: Floats = rng.uniform(1.5, HALF, (PEOPLE, 2))  # (p, 2) [m]
        self._velocities: Floats = np.zeros((PEOPLE, 2))
        self._until: Floats = np.zeros(PEOPLE)

    def walk(self, now: float, seconds: float) -> None:
        """Go on for some seconds from the time ``now`` [s]; walls turn people back."""
        for k in np.flatnonzero(now >= self._until).tolist():
            self._until[k] = now + self._rng.exponential(1.5)
            angle, speed = self._rng.uniform(-np.pi, np.pi), self._rng.uniform(0.0, WALKS)
            self._velocities[k] = speed * np.cos(angle), speed * np.sin(angle)
        self.places += self._velocities * seconds
        beyond = np.abs(self.places) > HALF
        self._velocities[beyond] = -np.sign(self.places[beyond]) * np.abs(self._velocities[beyond])


class Contact(NamedTuple):
    """A robot that moved while a body of it touched another one."""

    robot: str
    sample: int
    other: str


class Room:
    """The scene, and what is true in it."""

    def __init__(self) -> None:
        names = [f'person{k}' for k in range(PEOPLE)]
        frames = ''.join(f'- {{name: {n}, source: people, pose: {{}}}}\n' for n in names)
        shape = '{type: capsule, radius: 0.25, length: 1.2}'
        bodies = ''.join(
            f'- {{name: body, source: people, frame: {n}, shape: {shape}}}\n' for n in names
        )
        text = _ROOM.format(folder=HERE, frames=frames, bodies=bodies)
        self.graph = SceneGraph()
        loaded = load_scene(text, self.graph)
        self.joints = Joints.of(loaded)
        self.context = self.graph.CreateDefaultContext()
        self.frames = [loaded.frames['people', name].get_value() for name in names]
        of = {name: [] for name in (*ROBOTS, 'people')}
        for (source, _, _), geometry in loaded.geometries.items():
            of[source].append(geometry.get_value())
        self.geometries = {name: np.array(ids) for name, ids in of.items()}
        self.columns = {
            name: [k for k, joint in enumerate(self.joints.names) if joint.startswith(f'{name}::')]
            for name in ROBOTS
        }

    def people_poses(self, places: Floats) -> Floats:
        """Return the poses (..., p, 7) of people who stand at ``places`` (..., p, 2)."""
        poses = np.zeros((*places.shape[:-1], 7))
        poses[..., :2], poses[..., 2], poses[..., 6] = places, 0.9, 1.0
        return poses

    def see(self, places: Floats) -> None:
        """Pose people in the context."""
        rows = self.people_poses(places)
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(np.array(self.frames), rows))

    def gaps(self, positions: Floats, places: Floats, limit: float) -> dict[str, float]:
        """Return the least distance [m] of each robot from people and from other robots."""
        found = self._within(positions[None], places[None], limit)
        return {name: float(found[2][found[0] == k].min(initial=np.inf)) for k, name in
                enumerate(ROBOTS)}  # fmt: skip

    def contacts(self, positions: Floats, places: Floats, shares: Floats) -> list[Contact]:
        """Return the contacts of robots that move, of states (n, c), (n, p, 2), shares (n, r)."""
        contacts = []
        for first in range(0, len(positions), _BLOCK):
            block = slice(first, first + _BLOCK)
            robot, other, distance, row = self._within(positions[block], places[block], 1e-6)
            moving = shares[block][row, robot] > 0.0
            for k in np.flatnonzero(moving & (distance <= 0.0)).tolist():
                contacts.append(
                    Contact(ROBOTS[robot[k]], first + int(row[k]), (*ROBOTS, 'people')[other[k]])
                )
        return contacts

    def _within(self, positions: Floats, places: Floats, limit: float) -> tuple[Floats, ...]:
        """Return robot, other, distance and state of each pair of a robot with another body."""
        poses = np.concatenate((self.joints.poses(positions), self.people_poses(places)), axis=1)
        frames = [FrameId(int(f)) for f in (*self.joints.id_values.tolist(), *self.frames)]
        found = evaluate(self.graph, frames, poses, 'within', limit)
        rows = np.repeat(np.arange(len(poses)), np.diff(found.offsets))
        ends = np.array(
            [self._owner(np.asarray(ids)) for ids in (found.id_A, found.id_B)]
        )  # (2, k) 0: the arm, 1: the base, 2: people
        apart = ends[0] != ends[1]
        pairs = np.concatenate(
            (np.vstack((ends, rows, found.distance))[:, apart],
             np.vstack((ends[::-1], rows, found.distance))[:, apart]), axis=1
        )  # fmt: skip
        pairs = pairs[:, pairs[0] < len(ROBOTS)]
        robot, other, row = (pairs[k].astype(int) for k in (0, 1, 2))
        return robot, other, pairs[3], row

    def _owner(self, ids: Floats) -> Floats:
        owners = np.full(len(ids), len(ROBOTS))
        for k, name in enumerate(ROBOTS):
            owners[np.isin(ids, self.geometries[name])] = k
        return owners
