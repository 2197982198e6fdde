"""Motions of two bodies, beside python-fcl's ``continuousCollide`` and tesseract's cast.

Of the shapes that all take, along straight lines without a turn, and with one. Wrong verdicts are
judged by our proofs. FCL's motion is its CCDM_TRANS where nothing turns, else its CCDM_LINEAR,
which goes as slerp here; tesseract asks about the convex hull of start and end.
"""

from __future__ import annotations

from typing import Any

import fcl  # noqa: TID251  (the ban is for the package; this is a measurement of fcl itself)
import numpy as np
from fcl.collision_data import CCDMotionType, CCDSolverType  # noqa: TID251

from bench.motion.bodies import Floats, Scene, between, pose_rows
from bench.motion.clocks import clocked, told
from bench.motion.tesseract_side import CastManager, poses_of
from drake_geom_ros.cross_check.fcl_peer import fcl_shape
from drake_geom_ros.geometry import Box, Capsule, Cylinder, Sphere
from drake_geom_ros.geometry.queries.motion_queries import MotionQuestion
from drake_geom_ros.math.batched import matrices_from_poses

_A_PAIR = 20  # motions of each pair of bodies
_WAY, _TURN = 0.5, 0.8  # [m], [rad] that a body comes, about


class Motions:
    """Motions of one pair of bodies, in the containers of each library."""

    def __init__(self, rng: np.random.Generator, turn: float) -> None:
        self._turns = turn > 0.0
        self._shapes = [_shape(rng), _shape(rng)]
        self.scene = Scene(self._shapes)
        self.starts = np.stack([_poses(rng) for _ in range(_A_PAIR)])
        steps = rng.normal(scale=_WAY, size=(_A_PAIR, 2, 3))
        self.ends = self.starts.copy()
        self.ends[:, :, :3] += steps
        if turn > 0.0:
            self.ends[:, :, 3:] += rng.normal(scale=0.25 * turn, size=(_A_PAIR, 2, 4))
            self.ends[:, :, 3:] /= np.linalg.norm(self.ends[:, :, 3:], axis=2, keepdims=True)

    def ours(self, asked: MotionQuestion) -> tuple[list[Any], Floats]:
        """Return what is found of each, and the seconds."""
        pairs = [(pose_rows(s), pose_rows(e)) for s, e in zip(self.starts, self.ends, strict=True)]
        move = self.scene.motions.move
        return clocked(lambda motion: move(asked, *motion, 'slerp'), pairs)

    def fcl(self, solver: int, steps: int) -> tuple[list[Any], Floats]:
        """Return what FCL calls free, and the seconds."""
        request = fcl.ContinuousCollisionRequest(
            num_max_iterations=steps,
            ccd_motion_type=CCDMotionType.CCDM_LINEAR if self._turns else CCDMotionType.CCDM_TRANS,
            ccd_solver_type=solver,
        )
        shapes = [fcl_shape(shape) for shape in self._shapes]

        def is_free(motion: tuple[Any, ...]) -> bool:
            (one, end_one), (other, end_other) = motion
            result = fcl.ContinuousCollisionResult()
            fcl.continuousCollide(one, end_one, other, end_other, request, result)
            return not result.is_collide

        made = [
            [
                (fcl.CollisionObject(shape, _transform(start)), _transform(end))
                for shape, start, end in zip(shapes, starts, ends, strict=True)
            ]
            for starts, ends in zip(self.starts, self.ends, strict=True)
        ]
        return clocked(is_free, made)

    def tesseract(self) -> tuple[list[Any], Floats]:
        """Return what tesseract calls free, and the seconds."""
        bodies = {str(k): [(shape, np.eye(4))] for k, shape in enumerate(self._shapes)}
        manager = CastManager(bodies, list(bodies), [])
        made = [
            [poses_of(_matrices(poses)) for poses in motion]
            for motion in zip(self.starts, self.ends, strict=True)
        ]
        return clocked(manager.is_free, made)

    def depths(self) -> Floats:
        """Return the least distances [m] of states of each motion."""
        times = np.linspace(0.0, 1.0, 201)
        return np.array(
            [
                self.scene.upper_ends(between(start, end, times, 'slerp')).min()
                for start, end in zip(self.starts, self.ends, strict=True)
            ]
        )


def run(motions: int) -> None:
    """Print the times and the wrong verdicts of all."""
    for name, turn in (('without a turn', 0.0), ('with turns', _TURN)):
        rng = np.random.default_rng(0)
        _beside(name, [Motions(rng, turn) for _ in range(motions // _A_PAIR)])


def _sides() -> dict[str, Any]:
    advancing, naive = CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT, CCDSolverType.CCDC_NAIVE
    return {
        'proved, verdict alone': lambda m: m.ours(MotionQuestion(time_tolerance=1.0)),
        'proved, first contact within 1e-6': lambda m: m.ours(MotionQuestion()),
        'python-fcl, conservative advancement': lambda m: m.fcl(advancing, 10),
        'python-fcl, naive, 100 steps': lambda m: m.fcl(naive, 100),
        'tesseract, one cast': lambda m: m.tesseract(),
    }


def _beside(name: str, some: list[Motions]) -> None:
    sides = _sides()
    for motion in some:
        for work in sides.values():  # what is compiled or loaded once is not counted
            work(motion)
    closely = MotionQuestion(time_tolerance=1.0, bound_tolerance=1e-3)
    found = [check for motion in some for check in motion.ours(closely)[0]]
    outcomes = np.array([check.outcome for check in found])
    bounds = np.array([check.lower_bound for check in found])
    depths = np.concatenate([motion.depths() for motion in some])
    touch, clear = outcomes == 'contact', outcomes == 'clear'
    print(f'{len(found)} motions of two bodies {name}: {touch.sum()} touch, {clear.sum()} clear')
    results: dict[str, list[Any]] = {name: [] for name in sides}
    for motion in some:
        for side, work in sides.items():  # in turns
            results[side].append(work(motion))
    for side, parts in results.items():
        told(side, np.concatenate([seconds for _, seconds in parts]))
        if side.startswith('proved'):
            continue
        free = np.array([verdict for found, _ in parts for verdict in found], dtype=bool)
        missed, refused = free & touch, ~free & clear
        deep, far = (
            1e3 * (-depths[missed]).max(initial=0.0),
            1e3 * bounds[refused].max(initial=0.0),
        )
        print(
            f'    {missed.sum()} called free that touch, as deep as {deep:.1f} mm; '
            f'{refused.sum()} called touching that stay apart, by as much as {far:.1f} mm'
        )


def _shape(rng: np.random.Generator) -> Any:
    kinds = (
        lambda: Sphere(rng.uniform(0.02, 0.2)),
        lambda: Box(*rng.uniform(0.01, 0.5, 3)),
        lambda: Capsule(rng.uniform(0.01, 0.1), rng.uniform(0.1, 0.8)),
        lambda: Cylinder(rng.uniform(0.01, 0.1), rng.uniform(0.1, 0.8)),
    )
    return kinds[rng.integers(len(kinds))]()


def _poses(rng: np.random.Generator) -> Floats:
    """Return poses (2, 7)."""
    poses = rng.normal(size=(2, 7))
    poses[:, :3] = rng.uniform(-0.5, 0.5, (2, 3))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return poses


def _transform(pose: Floats) -> Any:
    return fcl.Transform(pose[[6, 3, 4, 5]], pose[:3])


def _matrices(poses: Floats) -> Floats:
    found = np.tile(np.eye(4), (len(poses), 1, 1))
    found[:, :3, :3], found[:, :3, 3] = matrices_from_poses(poses)
    return found
