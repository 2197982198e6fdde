"""Random motions of all shapes, by poses and by joints, against what is known of them.

A scan by our own distances tells where bodies touch for sure, and closed forms, to fifty digits,
when balls and planes first do. Some motions graze by construction: at exactly the least distance,
or a hair above or below.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.batches.ours import Ours
from drake_geom_ros import geometry
from drake_geom_ros.batch import check_paths, evaluate
from drake_geom_ros.geometry import Mesh
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries, MotionQuestion
from drake_geom_ros.geometry.queries.state_queries import PackedScene, StateQueries
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import matrices_from_poses

Floats = NDArray[np.float64]
_A_SCENE = 200  # motions of each scene
_SCAN = 64  # states of a scan
_ROUNDING = 1e-11  # [m] of interpolating here
_NEVER = np.zeros(1, dtype=np.int64)


class Scene:
    """Some bodies on a frame each, prepared for many motions."""

    def __init__(self, shapes: list[Any]) -> None:
        graph, ids = geometry.SceneGraph(), []
        source, properties = graph.RegisterSource('hunt'), geometry.ProximityProperties()
        properties.AddProperty('mesh', 'solid', True)
        for k, shape in enumerate(shapes):
            frame = graph.RegisterFrame(source, geometry.GeometryFrame(f'f{k}'))
            body = geometry.GeometryInstance(RigidTransform(), shape, 'body')
            body.set_proximity_properties(properties)
            graph.RegisterGeometry(source, frame, body)
            ids.append(frame.get_value())
        self.packed, _ = PackedScene.of(graph.CreateDefaultContext(), np.array(ids))
        self.motions = MotionQueries(self.packed, 'exact', _NEVER)
        self.states = StateQueries(self.packed)

    def check(self, starts: Floats, ends: Floats, asked: MotionQuestion, kind: str) -> Any:
        """Return what is found of the motion between poses (n, 7)."""
        return self.motions.move(asked, _rows(starts), _rows(ends), kind)

    def upper_ends(self, poses: Floats) -> Floats:
        """Return the upper ends (N,) of the least distances of states (N, n, 7) [m]."""
        counts, found = self.states.nearest(poses, 'exact', math.inf, 1, _NEVER)
        upper = np.full(len(poses), math.inf)
        upper[counts > 0] = found.distance + found.error_bound + _ROUNDING
        return upper


def _rows(poses: Floats) -> Floats:
    R, p = matrices_from_poses(poses)
    return np.hstack((R.reshape(-1, 9), p))


def slerp(starts: Floats, ends: Floats, times: Floats) -> Floats:
    """Return poses (N, n, 7) at times (N,): positions straight, quaternions by the shorter arc."""
    q, r = starts[:, 3:], ends[:, 3:].copy()
    cosine = np.einsum('ij,ij->i', q, r)
    r[cosine < 0.0] *= -1.0
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))[None, :, None]
    t = times[:, None, None]
    with np.errstate(invalid='ignore', divide='ignore'):
        a = np.where(angle < 1e-9, 1.0 - t, np.sin((1.0 - t) * angle) / np.sin(angle))
        b = np.where(angle < 1e-9, t, np.sin(t * angle) / np.sin(angle))
    turned = a * q + b * r
    turned /= np.linalg.norm(turned, axis=2, keepdims=True)
    return np.concatenate((starts[:, :3] + t * (ends[:, :3] - starts[:, :3]), turned), axis=2)


def random_shapes(rng: np.random.Generator, mesh: str) -> list[Any]:
    """Return two to four bodies of any kind."""
    kinds = (
        lambda: geometry.Sphere(rng.uniform(0.05, 0.5)),
        lambda: geometry.Box(*rng.uniform(0.02, 1.0, 3)),
        lambda: geometry.Capsule(rng.uniform(0.02, 0.3), rng.uniform(0.1, 1.5)),
        lambda: geometry.Cylinder(rng.uniform(0.02, 0.3), rng.uniform(0.1, 1.5)),
        lambda: geometry.Ellipsoid(*rng.uniform(0.05, 0.5, 3)),
        lambda: geometry.Convex(mesh, rng.uniform(0.3, 1.0)),
        lambda: Mesh(mesh, rng.uniform(0.3, 1.0)),
    )
    shapes = [kinds[rng.integers(len(kinds))]() for _ in range(rng.integers(2, 5))]
    if rng.integers(5) == 0:
        shapes[0] = geometry.HalfSpace()
    return shapes


def random_poses(rng: np.random.Generator, count: int) -> Floats:
    """Return poses (n, 7)."""
    poses = rng.normal(size=(count, 7))
    poses[:, :3] = rng.uniform(-1.5, 1.5, (count, 3))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return poses


def is_wrong(scene: Scene, starts: Floats, ends: Floats, found: Any, least: float) -> bool:
    """Tell whether a scan contradicts what was found of a motion by slerp."""
    times = np.linspace(0.0, 1.0, _SCAN + 1)
    upper = scene.upper_ends(slerp(starts, ends, times))
    wrong = bool((upper[times < found.times[0]] <= least).any())
    if found.outcome == 'clear':
        return wrong or bool(upper.min() < found.lower_bound) or bool(upper[-1] <= least)
    if found.outcome == 'contact':
        there = scene.upper_ends(slerp(starts, ends, np.array([found.times[1]])))
        return wrong or bool(there[0] - 4.0 * _ROUNDING > least)
    return wrong


def grazing(rng: np.random.Generator, scene: Scene, radii: tuple[float, float]) -> tuple[Any, int]:
    """Return what is found of a ball that passes another one by a hair, and whether it is wrong.

    The exact first time is that of a quadratic equation, in the hair by which it passes.
    """
    reach, hair = sum(radii), float(rng.choice([0.0, 1e-6, 1e-9, -1e-6, -1e-9]))
    off, begin, end = reach + hair, rng.uniform(-3, -1.5), rng.uniform(1.5, 3)
    starts, ends = np.tile([0.0, 0, 0, 0, 0, 0, 1], (2, 1)), np.tile([0.0] * 6 + [1.0], (2, 1))
    starts[0, :2], ends[0, :2] = (begin, off), (end, off)
    found = scene.check(starts, ends, MotionQuestion(), 'slerp')
    if hair > 0.0:
        return found, found.outcome == 'contact'
    if hair == 0.0:
        return found, found.outcome == 'clear'
    half = math.sqrt(-hair * (2.0 * reach + hair))
    first = (-half - begin) / (end - begin)
    t0, t1 = found.times
    early, late = t0 > first + 1e-9, found.outcome == 'contact' and t1 < first - 1e-9
    return found, found.outcome == 'clear' or early or late


def run(motions: int, seed: int) -> int:
    """Hunt; print what was found, and return 1 if anything was wrong."""
    rng, told, wrong = np.random.default_rng(seed), Counter[str](), 0
    mesh = str(_l_shape())
    began = time.process_time()
    for first in range(0, motions, _A_SCENE):
        by_joints = first // _A_SCENE % 5 == 4
        if by_joints:
            wrong += _by_joints(rng, min(_A_SCENE, motions - first), told)
            continue
        scene = Scene(random_shapes(rng, mesh))
        radii = tuple(rng.uniform(0.1, 0.5, 2).tolist())
        balls = Scene([geometry.Sphere(r) for r in radii])
        for number in range(min(_A_SCENE, motions - first)):
            if number % 20 == 0:
                found, bad = grazing(rng, balls, radii)
                kind = 'grazing'
            else:
                starts, ends = (random_poses(rng, len(scene.packed.moved)) for _ in range(2))
                least = float(rng.choice([0.0, 0.02]))
                found = scene.check(starts, ends, MotionQuestion(least), 'slerp')
                bad, kind = is_wrong(scene, starts, ends, found, least), 'poses'
            told[f'{kind}: {found.outcome}'] += 1
            wrong += bad
    _tell(told, wrong, motions, time.process_time() - began)
    return int(wrong > 0)


_arms: list[Ours] = []


def _by_joints(rng: np.random.Generator, count: int, told: Counter[str]) -> int:
    """Check random edges of two arms against a scan; return how many are wrong."""
    if not _arms:
        _arms.append(Ours())
    ours = _arms[0]
    lower, upper = ours.joints.lower, ours.joints.upper
    starts = rng.uniform(lower, upper, (count, ours.joints.count))
    ends = np.clip(starts + rng.normal(0.0, 0.15, starts.shape), lower, upper)
    paths = np.stack((starts, ends), axis=1)
    checks = check_paths(ours.scene_graph, ours.joints, paths, ignore_limits=True)
    times, wrong = np.linspace(0.0, 1.0, _SCAN + 1), 0
    states = starts[:, None] + times[:, None] * (ends - starts)[:, None]
    flat = states.reshape(-1, ours.joints.count)
    least = evaluate(ours.scene_graph, states=flat, joints=ours.joints, want='least')
    ends_up = (least.distance + least.error_bound + _ROUNDING).reshape(count, -1)
    for check, up in zip(checks, ends_up, strict=True):
        told[f'joints: {check.outcome}'] += 1
        bad = (up[times < check.last_free] <= 0.0).any()
        if check.outcome == 'clear':
            bad |= up.min() < check.lower_bound or up.min() <= 0.0
        wrong += int(bad)
    return wrong


def _l_shape() -> Any:
    """Write an L-shaped prism to a file and return where it is."""
    import tempfile
    from pathlib import Path

    outline = [(0, 0), (1, 0), (1, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)]
    points = [(x - 0.3, y - 0.3, z) for z in (-0.15, 0.15) for x, y in outline]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(c, b, a) for a, b, c in caps] + [(a + 6, b + 6, c + 6) for a, b, c in caps]
    for k in range(6):
        n = (k + 1) % 6
        faces += [(k, n, n + 6), (k, n + 6, k + 6)]
    path = Path(tempfile.mkdtemp()) / 'l.obj'
    lines = [f'v {x} {y} {z}' for x, y, z in points]
    path.write_text('\n'.join(lines + [f'f {a + 1} {b + 1} {c + 1}' for a, b, c in faces]) + '\n')
    return path


def _tell(told: Counter[str], wrong: int, motions: int, seconds: float) -> None:
    unknown = sum(count for kind, count in told.items() if kind.endswith('unknown'))
    by_hair = told['grazing: unknown']
    print(
        f'{motions} motions, {seconds:.0f} s of processor time: {wrong} wrong, {unknown} unknown'
    )
    print(
        f'  ({unknown - by_hair} of them not grazing: {100 * (unknown - by_hair) / motions:.3f} %)'
    )
    for kind, count in sorted(told.items()):
        print(f'  {kind} {count}')
