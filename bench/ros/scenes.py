"""The scenes of the delay benchmark, each with the poses of its frames over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.ros.processes import ROOT
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion_file import load_motion
from truth.bodies.random_bodies import random_directions

_SHAPES = (
    '{type: sphere, radius: 0.1}',
    '{type: box, size: [0.2, 0.15, 0.1]}',
    '{type: capsule, radius: 0.05, length: 0.15}',
    '{type: cylinder, radius: 0.08, length: 0.15}',
    '{type: ellipsoid, semi_axes: [0.06, 0.08, 0.1]}',
)
_SPACING = 0.3  # [m] of the grid that bodies stand in
_SWAY = 0.08  # [m] of each body about its place
_PERIOD = 4.0  # [s]


@dataclass(frozen=True)
class Played:
    """A scene file, the names of the frames that move, and their poses (n, 7) at a time [s]."""

    scene_file: Path
    frame_names: list[str]
    poses: Callable[[float], NDArray[np.float64]]


def two_arms() -> Played:
    """Return the demo's two arms."""
    scene_file = ROOT / 'scenes/two_pandas.yaml'
    motion = load_motion(ROOT / 'scenes/two_pandas_motion.yaml', read_scene(scene_file))
    names = [f'{source}::{name}' for source, all in motion.frame_names.items() for name in all]

    def poses(time: float) -> NDArray[np.float64]:
        found = motion.poses(time % motion.duration)
        return np.concatenate([found[source] for source in motion.frame_names])

    return Played(scene_file, names, poses)


def scene_text(names: Sequence[str], shapes: Sequence[str]) -> str:
    """Return the text of a scene file with a body on each of the frames named."""
    lines = ['sources: [s]', 'frames:', *(f'- {{name: {name}, source: s}}' for name in names)]
    lines.append('geometries:')
    for name, shape in zip(names, shapes, strict=True):
        lines.append(f'- {{name: g, source: s, frame: {name}, shape: {shape}}}')
    return '\n'.join(lines) + '\n'


def bodies(count: int, folder: Path) -> Played:
    """Return ``count`` bodies of five shapes in a grid, each swaying about its place."""
    random = np.random.default_rng(count)
    names = [f'b{k}' for k in range(count)]
    scene_file = folder / f'{count}_bodies.yaml'
    scene_file.write_text(scene_text(names, [_SHAPES[k % len(_SHAPES)] for k in range(count)]))
    side = int(np.ceil(count ** (1 / 3)))
    rest = np.empty((count, 7))
    rest[:, :3] = _SPACING * np.stack(np.unravel_index(np.arange(count), (side,) * 3), axis=1)
    for k in range(count):
        orientation = RollPitchYaw(random.uniform(-3.0, 3.0, 3)).ToRotationMatrix()
        rest[k, 3:] = RigidTransform(orientation, [0, 0, 0]).ToArray()[3:]
    directions = random_directions(random, count)
    phases = random.uniform(0.0, 2 * np.pi, (count, 1))

    def poses(time: float) -> NDArray[np.float64]:
        moved = rest.copy()
        moved[:, :3] += _SWAY * np.sin(2 * np.pi * time / _PERIOD + phases) * directions
        return moved

    return Played(scene_file, names, poses)
