"""Random bodies on frames, some of them on one another, and their poses between two poses."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros import geometry
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries, MotionQuestion
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.geometry.queries.state_queries import StateQueries
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import matrices_from_poses

Floats = NDArray[np.float64]
ROUNDING = 1e-11  # [m] of interpolating here
_NEVER = np.zeros(1, dtype=np.int64)


class Scene:
    """Bodies on a frame each, prepared for many motions; ``parents`` are frames that carry one."""

    def __init__(
        self,
        shapes: list[Any],
        parents: list[int] | None = None,
        solids: list[bool] | None = None,
    ) -> None:
        graph, ids = geometry.SceneGraph(), []
        source, frames = graph.RegisterSource('hunt'), [graph.world_frame_id()]
        for k, shape in enumerate(shapes):
            carrier = frames[1 + parents[k]] if parents else frames[0]
            frames.append(graph.RegisterFrame(source, carrier, geometry.GeometryFrame(f'f{k}')))
            properties = geometry.ProximityProperties()
            properties.AddProperty('mesh', 'solid', solids[k] if solids else True)
            body = geometry.GeometryInstance(RigidTransform(), shape, 'body')
            body.set_proximity_properties(properties)
            graph.RegisterGeometry(source, frames[-1], body)
            ids.append(frames[-1].get_value())
        self.packed, _ = PackedScene.of(graph.CreateDefaultContext(), np.array(ids))
        self.motions = MotionQueries(self.packed, 'exact', _NEVER)
        self.states = StateQueries(self.packed)

    def check(self, starts: Floats, ends: Floats, asked: MotionQuestion, kind: str) -> Any:
        """Return what is found of the motion between poses (n, 7)."""
        return self.motions.move(asked, pose_rows(starts), pose_rows(ends), kind)

    def upper_ends(self, poses: Floats) -> Floats:
        """Return the upper ends (N,) of the least distances of states (N, n, 7) [m]."""
        counts, found = self.states.nearest(poses, 'exact', math.inf, 1, _NEVER)
        upper = np.full(len(poses), math.inf)
        size = 1.0 + np.abs(poses[:, :, :3]).max()
        upper[counts > 0] = found.distance + found.error_bound + ROUNDING * size
        return upper


def pose_rows(poses: Floats) -> Floats:
    """Return poses (n, 7) as rows (n, 12) of R and p, which a check takes."""
    R, p = matrices_from_poses(poses)
    return np.hstack((R.reshape(-1, 9), p))


def between(starts: Floats, ends: Floats, times: Floats, kind: str) -> Floats:
    """Return poses (N, n, 7) at times (N,): rotations by the shorter arc of quaternions."""
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
    step = ends[:, :3] - starts[:, :3]
    places = starts[:, :3] + t * step
    if kind == 'screw':
        places = _on_screws(starts[:, :3], step, q, r, t)
    return np.concatenate((places, turned), axis=2)


def _on_screws(p: Floats, step: Floats, q: Floats, r: Floats, t: Floats) -> Floats:
    """Return positions (N, n, 3) on the screws from p by a step, turning from q to r.

    By the point c that the axis goes through (Chasles): what is across the axis turns about c.
    """
    # The turn r q*, in World axes: its vector part is the axis times the sine of half the angle.
    vector = q[:, 3:] * r[:, :3] - r[:, 3:] * q[:, :3] - np.cross(r[:, :3], q[:, :3])
    sine = np.linalg.norm(vector, axis=1, keepdims=True)
    half = np.arctan2(sine, (q * r).sum(axis=1, keepdims=True))
    turns = sine[:, 0] > 1e-9
    w = np.where(turns[:, None], vector / np.where(sine == 0.0, 1.0, sine), 0.0)
    along = (step * w).sum(axis=1, keepdims=True) * w
    tangent = np.where(turns[:, None], np.tan(half), 1.0)
    arm = 0.5 * ((step - along) + np.cross(w, step) / tangent)  # from p to c
    angle = 2.0 * half * t
    turned = np.cos(angle) * -arm + np.sin(angle) * np.cross(w, -arm)
    places: Floats = np.where(turns[:, None], p + t * along + arm + turned, p + t * step)
    return places


def random_scene(rng: np.random.Generator, mesh: str) -> Scene:
    """Return two to four bodies of any kind; some hang on another one, and go with it."""
    kinds = (
        lambda: geometry.Sphere(rng.uniform(0.05, 0.5)),
        lambda: geometry.Box(*rng.uniform(0.02, 1.0, 3)),
        lambda: geometry.Box(*rng.uniform(0.1, 1.0, 2), 10 ** rng.uniform(-9, -3)),
        lambda: geometry.Capsule(rng.uniform(0.02, 0.3), rng.uniform(0.1, 1.5)),
        lambda: geometry.Cylinder(rng.uniform(0.02, 0.3), rng.uniform(0.1, 1.5)),
        lambda: geometry.Ellipsoid(*rng.uniform(0.05, 0.5, 3)),
        lambda: geometry.Convex(mesh, rng.uniform(0.3, 1.0)),
        lambda: geometry.Mesh(mesh, rng.uniform(0.3, 1.0)),
    )
    count = int(rng.integers(2, 5))
    shapes: list[Any] = [kinds[rng.integers(len(kinds))]() for _ in range(count)]
    if rng.integers(5) == 0:
        shapes[0] = geometry.HalfSpace()
    parents = [int(rng.integers(k)) if k and rng.integers(4) == 0 else -1 for k in range(count)]
    return Scene(shapes, parents, [bool(rng.integers(2)) for _ in range(count)])


def random_motion(rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    """Return poses (n, 7) to start from and to end at: far, near, without a turn, or at rest."""
    starts, ends = random_poses(rng, count), random_poses(rng, count)
    kind = rng.integers(5)
    if kind == 1:  # a little
        ends = starts + 10 ** rng.uniform(-4, -1) * rng.normal(size=starts.shape)
        ends[:, 3:] /= np.linalg.norm(ends[:, 3:], axis=1, keepdims=True)
    if kind == 2:
        ends[:, 3:] = starts[:, 3:]
    if kind == 3:  # in place
        ends[:, :3] = starts[:, :3]
    rest = rng.integers(4, size=count) == 0
    ends[rest] = starts[rest]
    return starts, ends


def random_poses(rng: np.random.Generator, count: int) -> Floats:
    """Return poses (n, 7)."""
    poses = rng.normal(size=(count, 7))
    poses[:, :3] = rng.uniform(-1.5, 1.5, (count, 3))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return poses


def l_shape() -> str:
    """Write an L-shaped prism to a file, and return where it is: as a hull its corner is full."""
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
    return str(path)
