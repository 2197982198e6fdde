"""The ladder: scenes from two spheres upwards, each a scene file and the poses of its frames.

A rung is written into a folder of its own, so that the process that is measured finds all that it
needs there and imports nothing that its scene does not call for.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.ros.scenes import scene_text, two_arms
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import random_directions

SCENE, FRAMES, POSES = 'scene.yaml', 'frames.json', 'poses.npy'  # the files of a rung
CYCLES = 200  # poses of a rung, one a cycle
RATE = 100.0  # [Hz] of them
_SWAY = 0.05  # [m] of each body about its place
_ARM = """
sources: [left]
robots:
- name: left
  urdf: package://example-robot-data/robots/panda_description/urdf/panda_collision.urdf
"""


@dataclass(frozen=True)
class Rung:
    """A scene of the ladder; ``write(folder)`` fills a folder with it."""

    name: str
    says: str
    write: Callable[[Path], None]


def _put(folder: Path, scene: str, frames: list[str], poses: Floats) -> None:
    """Write the files of a rung; ``poses`` (cycles, n, 7) are X_PF of the frames."""
    (folder / SCENE).write_text(scene)
    (folder / FRAMES).write_text(json.dumps(frames))
    np.save(folder / POSES, poses)


def _swaying(places: Floats) -> Floats:
    """Return poses (CYCLES, n, 7) of bodies that sway about places (n, 3)."""
    phases = np.arange(len(places))
    times = np.arange(CYCLES)[:, None] / RATE
    poses = np.zeros((CYCLES, len(places), 7))
    poses[..., :3] = places
    poses[..., 0] += _SWAY * np.sin(2.0 * np.pi * times + phases)
    poses[..., 6] = 1.0
    return poses


def _grid(count: int, spacing: float) -> Floats:
    """Return places (count, 3) on a flat grid."""
    side = int(np.ceil(np.sqrt(count)))
    places = np.zeros((count, 3))
    places[:, 0], places[:, 1] = spacing * (np.arange(count) % side), np.arange(count) // side
    places[:, 1] *= spacing
    return places


def _bodies(folder: Path, shapes: list[str], spacing: float, extra: str = '') -> None:
    """Write moving bodies of the shapes, beside what ``extra`` registers."""
    names = [f'b{k}' for k in range(len(shapes))]
    places = _grid(len(shapes), spacing)
    _put(folder, scene_text(names, shapes) + extra, names, _swaying(places))


_SPHERE = '{type: sphere, radius: 0.1}'


def two_spheres(folder: Path) -> None:
    _bodies(folder, [_SPHERE] * 2, 0.25)


def illustrated(folder: Path) -> None:
    """Write the two spheres, and 1000 boxes that only people see, fixed to a frame that moves."""
    seen = '{type: box, size: [0.1, 0.1, 0.1]}, roles: {illustration: {}}'
    extra = (f'- {{name: seen_{k}, source: s, frame: b0, shape: {seen}}}' for k in range(1000))
    _bodies(folder, [_SPHERE] * 2, 0.25, '\n'.join(extra) + '\n')


def anchored(folder: Path) -> None:
    """Write 30 spheres that move above a floor of 1000 anchored boxes."""
    extra = []
    for k, (x, y, _) in enumerate(_grid(1000, 0.2).tolist()):
        pose = f'{{position: [{x}, {y}, -0.2]}}'
        shape = '{type: box, size: [0.18, 0.18, 0.1]}'
        extra.append(f'- {{name: tile_{k}, source: s, pose: {pose}, shape: {shape}}}')
    _bodies(folder, [_SPHERE] * 30, 0.25, '\n'.join(extra) + '\n')


def _hull_points(seed: int, count: int) -> Floats:
    """Return points (count, 3) on a sphere of radius 0.1 m, all of them corners of the hull."""
    return np.round(0.1 * random_directions(np.random.default_rng(seed), count), 6)


def hulls(folder: Path) -> None:
    """Write 20 convex hulls that came as numbers, of 32 corners each."""
    points = [_hull_points(seed, 32).tolist() for seed in range(20)]
    _bodies(folder, [f'{{type: convex, vertices: {p}}}' for p in points], 0.22)


def meshes(folder: Path) -> None:
    """Write 20 meshes of one file of 2048 triangles, a ball with bumps."""
    turns, heights = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 32, False), np.linspace(-1, 1, 33))
    radii = 0.1 * np.sqrt(1.0 - heights**2) * (1.0 + 0.05 * np.cos(5.0 * turns))
    vertices = np.stack(
        (radii * np.cos(turns), radii * np.sin(turns), 0.1 * heights), axis=-1
    ).reshape(-1, 3)
    lines = [f'v {x:.6f} {y:.6f} {z:.6f}' for x, y, z in vertices]
    for row in range(32):
        for k in range(32):
            a, b = 32 * row + k + 1, 32 * row + (k + 1) % 32 + 1
            lines += [f'f {a} {b} {b + 32}', f'f {a} {b + 32} {a + 32}']
    (folder / 'ball.obj').write_text('\n'.join(lines) + '\n')
    _bodies(folder, ['{type: mesh, uri: ball.obj}'] * 20, 0.22)


def arms(folder: Path) -> None:
    """Write the demo's two arms over a table, with things on it."""
    played = two_arms()
    poses = np.stack([played.poses(cycle / RATE) for cycle in range(CYCLES)])
    _put(folder, played.scene_file.read_text(), played.frame_names, poses)


def arm(folder: Path) -> None:
    """Write the left one of the two arms alone."""
    played = two_arms()
    own = [k for k, name in enumerate(played.frame_names) if name.startswith('left::')]
    poses = np.stack([played.poses(cycle / RATE)[own] for cycle in range(CYCLES)])
    _put(folder, _ARM, [played.frame_names[k] for k in own], poses)


# From little to much: with a cache that is shared, a rung compiles what it adds to those before.
LADDER = (
    Rung('two spheres', 'two spheres that move', two_spheres),
    Rung('1000 illustrations', 'the two spheres, and 1000 boxes for people only', illustrated),
    Rung('1000 anchored', '30 spheres that move above 1000 anchored boxes', anchored),
    Rung('hulls', '20 convex hulls of 32 corners, given as numbers', hulls),
    Rung('meshes', '20 meshes of one file, 2048 triangles, taken as their hulls', meshes),
    Rung('one arm', 'a Panda from its URDF: 11 links', arm),
    Rung('two arms', "the demo's two arms, table and things", arms),
)
