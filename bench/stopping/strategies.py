"""What says how fast robots may go: the proof of stops, a distance that is as safe, or nothing."""

from __future__ import annotations

import numpy as np

from bench.stopping.robots import BRAKES, CYCLE, REACTION, SPEEDS, Walker
from bench.stopping.room import ROBOTS, WALKS, Room
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.stopping import (
    Braking,
    RobotState,
    Stop,
    StoppingCheck,
    StoppingQuestion,
    robots_of,
)

MARGIN = 0.05  # [m]
HEADROOM = 0.9  # of a share that is proved: what is under way stays proved while it falls slowly
_FASTEST = {'arm': 1.85, 'base': 1.14}  # [m/s] of any point at the nominal speed


class Unrestricted:
    """Nothing slows the robots."""

    def __init__(self, room: Room) -> None:
        pass

    def shares(self, robots: list[Walker], places: Floats, age: float) -> list[float]:
        """Return the share of its nominal speed for each robot."""
        return [1.0 for _ in robots]


class PlainDistance:
    """A robot stands while anything is nearer than all that may move until it has stopped."""

    def __init__(self, room: Room) -> None:
        self._room = room
        self._travel = {
            name: _FASTEST[name] * (CYCLE + REACTION + 0.5 * SPEEDS[name] / BRAKES[name])
            for name in ROBOTS
        }
        self._stands = dict.fromkeys(ROBOTS, True)

    def limit(self, name: str, age: float) -> float:
        """Return the distance [m] below which a robot stands."""
        seconds = age + CYCLE + REACTION + SPEEDS[name] / BRAKES[name]
        other = next(each for each in ROBOTS if each != name)
        return self._travel[name] + max(WALKS * seconds, self._travel[other]) + MARGIN

    def shares(self, robots: list[Walker], places: Floats, age: float) -> list[float]:
        """Return the share of its nominal speed for each robot."""
        positions = np.concatenate([robot.positions for robot in robots])
        gaps = self._room.gaps(positions, places, 4.0)
        for robot in robots:
            room = 0.05 if self._stands[robot.name] else 0.0
            self._stands[robot.name] = gaps[robot.name] < self.limit(robot.name, age) + room
        return [0.0 if self._stands[robot.name] else 1.0 for robot in robots]


class Stoppable:
    """A robot goes as fast as its stop is proved to end before contact."""

    def __init__(self, room: Room, **options: object) -> None:
        self._room, self._robots = room, robots_of(room.joints)
        questions = []
        for name in ROBOTS:
            joints = tuple(room.joints.names[k] for k in room.columns[name])
            braking = Braking(joints, (BRAKES[name],) * len(joints), reaction_time=REACTION)
            questions.append(
                StoppingQuestion(
                    braking, room.geometries[name].tolist(), margin=MARGIN, max_speed=WALKS
                )
            )
        self._check = StoppingCheck(room.context, self._robots, questions, **options)

    def shares(self, robots: list[Walker], places: Floats, age: float) -> list[float]:
        """Return the share of its nominal speed for each robot."""
        stops = self.ask(
            [robot.positions for robot in robots],
            [robot.velocities for robot in robots],
            places,
            age,
        )
        return [
            HEADROOM * stop.scale if robot.in_flight <= stop.scale else 0.0
            for stop, robot in zip(stops, robots, strict=True)
        ]

    def ask(
        self, positions: list[Floats], velocities: list[Floats], places: Floats, age: float
    ) -> list[Stop]:
        """Return the answer for each robot."""
        self._room.see(places)
        states = [
            RobotState(arm.X_WB, q, v)
            for arm, q, v in zip(self._room.joints.arms, positions, velocities, strict=True)
        ]
        ages = np.where(np.isin(self._check.ids, self._room.geometries['people']), age, 0.0)
        return self._check.stops(states, ages, CYCLE)


STRATEGIES = {
    'unrestricted': Unrestricted,
    'plain distance': PlainDistance,
    'stoppable': Stoppable,
}
