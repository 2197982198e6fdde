"""Some time in the room with one strategy, and what the referee saw."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from bench.stopping.robots import CYCLE, STEPS, Walker
from bench.stopping.room import ROBOTS, People, Room
from drake_geom_ros.math.array_types import Floats

DELAY = 0.1  # [s] that a person is seen late


@dataclass
class Outcome:
    """What became of one run."""

    seconds: float  # [s] that were simulated
    gone: dict[str, float]  # [s] of motion at the nominal speed, by robot
    contacts: int  # moments at which a robot moved and touched something
    cost: float  # [s] of computing each decision, the median
    trace: list[tuple[float, ...]] = field(default_factory=list)  # shares of the first seconds


def simulate(strategy: Any, room: Room, seconds: float, seed: int) -> Outcome:
    """Run a strategy for some simulated seconds; the referee judges each step by the truth."""
    rng = np.random.default_rng(seed)
    people = People(np.random.default_rng([seed, 1]))
    robots = [
        Walker(name, room.joints.lower[columns], room.joints.upper[columns], rng)
        for name, columns in room.columns.items()
    ]
    seen: deque[Floats] = deque([people.places.copy()] * (round(DELAY / CYCLE) + 1))
    steps, shares, places, costs, trace = [], [], [], [], []
    for cycle in range(round(seconds / CYCLE)):
        seen.append(people.places.copy())
        seen.popleft()
        start = perf_counter()
        allowed = strategy.shares(robots, seen[0], DELAY)
        costs.append(perf_counter() - start)
        for robot, share in zip(robots, allowed, strict=True):
            robot.command(share)
        moves = [robot.move() for robot in robots]
        for step in range(STEPS):
            people.walk(cycle * CYCLE + step * CYCLE / STEPS, CYCLE / STEPS)
            steps.append(np.concatenate([move[step][0] for move in moves]))
            shares.append([move[step][1] for move in moves])
            places.append(people.places.copy())
        if len(trace) < 600:
            trace.append(tuple(robot.share for robot in robots))
    found = room.contacts(np.array(steps), np.array(places), np.array(shares))
    gone = {robot.name: robot.gone for robot in robots}
    moments = len({(contact.robot, contact.sample) for contact in found})
    assert list(gone) == list(ROBOTS)
    return Outcome(seconds, gone, moments, float(np.median(costs)), trace)
