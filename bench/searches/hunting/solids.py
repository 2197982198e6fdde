"""The search among solids: flush and nearly flush placements, whose truth a lattice tells.

Each generation makes two solids and a ball, places them many times, and asks at every level, by
contexts that were asked before and by fresh ones, and by batches.
"""

from __future__ import annotations

import math

import numpy as np

from bench.searches.hunting.lattice import SIDE, Lattice, random_lattice, truth
from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    MeshFileError,
    ProximityProperties,
    SceneGraph,
    SceneGraphContext,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats

LAWS = {
    'certificate': 'the true distance lies within `error_bound`, at every level',
    'contact': 'overlaps deeper than rounding hides, and only overlaps, are collisions',
    'point': 'the true distance of a point lies within its `error_bound`',
    'near': 'what is within `max_distance` is listed',
    'memory': 'what was asked before changes an answer by no more than its bounds, and at '
    '`exact` by no more than 1e-10 of the size',
    'batch': '`least` and `nearest` are those of fresh contexts, to the bit',
}
HIDDEN = 2e-14  # of how far bodies reach from their origins, and those from each other: see LAWS
SAME = 1e-10  # of the bodies' size: what earlier questions may change, as the docs promise
PLACES = 12  # states a generation
NEAREST, FARTHEST = -15.0, -2.0  # decades of a cell that a placement is off the lattice
POINTS = 6


class SolidHunt:
    """A search that goes on by generations; deterministic for a seed.

    ``worst`` has the worst ratio of each law and kind of solids, ``broken`` how often it was
    broken, ``examples`` one placement that broke it; ``refused`` meshes that were none.
    """

    def __init__(self, seed: int) -> None:
        self.worst: dict[tuple[str, str], float] = {}
        self.broken: dict[tuple[str, str], int] = {}
        self.examples: dict[tuple[str, str], str] = {}
        self.judged = self.refused = 0
        self._rng = np.random.default_rng([seed, SIDE])

    @property
    def laws_broken(self) -> set[str]:
        """The laws that were broken."""
        return {law for law, _ in self.broken}

    def generation(self) -> None:
        """Make solids, place them, and judge what is answered."""
        rng = self._rng
        a = random_lattice(rng)
        b = random_lattice(rng)
        while b.about.split(',')[0] != a.about.split(',')[0]:
            b = random_lattice(rng)
        try:
            scene = _Scene(a, b, rng)
        except MeshFileError:
            self.refused += 1
            return
        places = [self._place(a, b) for _ in range(PLACES)]
        live = scene.graph.CreateDefaultContext()
        for p in places:
            self._judge(scene, live, p)
        self._judge_batch(scene, places)

    def _place(self, a: Lattice, b: Lattice) -> Floats:
        """Return where b is put: on the lattice, a little off it along some axes, or anywhere."""
        unit, rng = float(np.ptp(a.lines[0])) / SIDE, self._rng
        step = rng.integers(-SIDE, SIDE + 1, 3) + rng.choice([0.0, 0.0, 0.5])
        off = rng.choice([-1.0, 0.0, 0.0, 1.0], 3) * 10.0 ** rng.uniform(NEAREST, FARTHEST)
        p: Floats = unit * (step + off) + (a.lines - b.lines)[:, 0]
        return p

    def _judge(self, scene: _Scene, live: SceneGraphContext, p: Floats) -> None:
        least, most = truth(scene.a.boxes(np.zeros(3)), scene.b.boxes(p))
        size, about = scene.size, f'{scene.a} | {scene.b} | p = {p.tolist()}'
        state = scene.state(p)
        rows = {}
        for level in self._rng.permutation(ACCURACY_LEVELS).tolist():
            fresh = scene.query(scene.graph.CreateDefaultContext(), state)
            (pair,) = scene.solids_of(
                fresh.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
            )
            d, e = rows[level] = pair.distance, pair.error_bound
            allowed = e + 4.0 * math.ulp(abs(d) + abs(least))  # of the truth as told
            self._keep('certificate', scene, max(d - most, least - d) / allowed, about)
            asked = scene.query(live, state)
            known = scene.solids_of(
                asked.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
            )
            again, bound = known[0].distance, known[0].error_bound
            told = e + bound if level != 'exact' else min(e + bound, SAME * size)
            self._keep('memory', scene, abs(again - d) / (told + math.ulp(d)), about)
            if most > 0.0:
                reach = most * (1.0 + 1e-15)
                near = asked.ComputeSignedDistancePairwiseClosestPoints(reach, accuracy=level)
                self._keep('near', scene, 0.0 if scene.solids_of(near) else math.inf, about)
        collides = fresh.HasCollisions()
        seen = -most / (HIDDEN * (scene.reach + float(np.linalg.norm(p))))
        wrong = math.inf if collides and least >= 0.0 else 0.0 if collides else seen
        self._keep('contact', scene, wrong, about)
        self._judge_points(scene, state)
        self.judged += 1

    def _judge_points(self, scene: _Scene, state: Floats) -> None:
        rng, lines = self._rng, scene.a.lines
        on = rng.integers(0, SIDE + 1, (POINTS, 3)) + rng.choice([0.0, 0.5], (POINTS, 3))
        unit = float(np.ptp(lines[0])) / SIDE
        off = rng.normal(size=(POINTS, 3)) * 10.0 ** rng.uniform(NEAREST, 0.0, (POINTS, 1))
        points = lines[:, 0] + unit * (on + off)
        query = scene.query(scene.graph.CreateDefaultContext(), state)
        found = query.ComputeSignedDistanceToPoint(points)
        mine = found.id_G == scene.ids[0].get_value()
        for q, d, e in zip(points, found.distance[mine], found.error_bound[mine], strict=True):
            known = scene.a.signed_distance(q)
            ratio = abs(d - known) / (e + 4.0 * math.ulp(known))
            self._keep('point', scene, ratio, f'{scene.a} | q = {q.tolist()}')

    def _judge_batch(self, scene: _Scene, places: list[Floats]) -> None:
        poses = np.array([scene.state(p) for p in places])
        level, count = str(self._rng.choice(ACCURACY_LEVELS)), int(self._rng.integers(1, 4))
        asked = {'accuracy': level, 'want': 'nearest', 'count': count}
        found = evaluate(scene.graph, scene.frames, poses, **asked)  # type: ignore[arg-type]
        for k, state in enumerate(poses):
            query = scene.query(scene.graph.CreateDefaultContext(), state)
            every = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
            ends = np.array(every.distance) - every.error_bound
            first = np.argsort(ends, kind='stable')[:count]
            rows = slice(*found.offsets[k : k + 2])
            same = all(
                np.array_equal(getattr(found, name)[rows], np.array(getattr(every, name))[first])
                for name in ('distance', 'error_bound', 'nhat_BA_W', 'p_WCa', 'p_WCb')
            )
            about = f'{scene.a} | {scene.b} | p = {places[k].tolist()} | {level}'
            self._keep('batch', scene, 0.0 if same else math.inf, about)

    def _keep(self, law: str, scene: _Scene, ratio: float, about: str) -> None:
        """Remember the worst of a law."""
        key = law, scene.about
        ratio = max(0.0, ratio if ratio == ratio else math.inf)
        if ratio > 1.0:
            self.broken[key] = self.broken.get(key, 0) + 1
        if ratio > max(1.0, self.worst.get(key, 0.0)):
            self.examples[key] = about
        self.worst[key] = max(self.worst.get(key, 0.0), ratio)


class _Scene:
    """Two solids and a ball, each on a frame of its own."""

    def __init__(self, a: Lattice, b: Lattice, rng: np.random.Generator) -> None:
        self.a, self.b = a, b
        kinds = sorted({part for each in (a, b) for part in each.about.split(', ')[1:]})
        self.about = ', '.join(['solids', *kinds])
        self.size = float(np.ptp(a.lines, axis=1).max() + np.ptp(b.lines, axis=1).max())
        self.reach = float(sum(np.linalg.norm(each.vertices, axis=1).max() for each in (a, b)))
        self._far = a.lines[:, 0] + self.size * rng.uniform(1.0, 2.0, 3)
        self.graph = SceneGraph()
        source = self.graph.RegisterSource('hunt')
        self.frames: list[FrameId] = []
        self.ids = []
        properties = ProximityProperties()
        properties.AddProperty('mesh', 'solid', True)
        for k, shape in enumerate((a.mesh, b.mesh, Sphere(0.1 * self.size))):
            frame = self.graph.RegisterFrame(source, GeometryFrame(str(k)))
            body = GeometryInstance(RigidTransform(), shape, 'body')
            body.set_proximity_properties(properties)
            self.frames.append(frame)
            self.ids.append(self.graph.RegisterGeometry(source, frame, body))
        self.ids.pop()

    def state(self, p: Floats) -> Floats:
        """Return the poses (3, 7) where b is at p."""
        poses = np.zeros((3, 7))
        poses[:, 6], poses[1, :3], poses[2, :3] = 1.0, p, self._far
        return poses

    def query(self, context: SceneGraphContext, state: Floats):  # type: ignore[no-untyped-def]
        """Return the query of a context in a state."""
        ids = np.array([frame.get_value() for frame in self.frames])
        context.UpdateFramePoses(FramePoseVector.FromArrays(ids, state))
        return self.graph.get_query_output_port().Eval(context)

    def solids_of(self, found):  # type: ignore[no-untyped-def]
        """Return the answers about the two solids."""
        return [pair for pair in found if [pair.id_A, pair.id_B] == self.ids]
