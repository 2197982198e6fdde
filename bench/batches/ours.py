"""The scene of two Pandas that all sides are asked about, and our side of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros import geometry
from drake_geom_ros.batch import Joints
from drake_geom_ros.scene_files import LoadedScene, load_scene

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / 'scenes/two_pandas.yaml'
FOOT = 'panda_link0'
BELOW, FLOOR = '{position: [0, 0, -0.1]}', '{type: box, size: [4, 4, 0.2]}'


class Ours:
    """The scene, and the pairs of geometries that are not filtered, by name."""

    def __init__(self) -> None:
        # pydrake knows no distance of a cylinder and a half space.
        text = SCENE.read_text().replace(
            'shape: {type: half_space}', f'pose: {BELOW}, shape: {FLOOR}'
        )
        self.text = text
        self.scene_graph = geometry.SceneGraph()
        self.loaded: LoadedScene = load_scene(text, self.scene_graph)
        self.joints = Joints.of(self.loaded)
        self.names = {id: name for name, id in self.loaded.geometries.items()}
        robots = set(self.loaded.robots)
        standing = [
            id
            for (source, link, _), id in self.loaded.geometries.items()
            if source not in robots or link == FOOT
        ]
        self.standing = [id for id in standing if self.names[id][0] not in robots]
        self.exclude(geometry.GeometrySet(standing))
        self._make_even()

    def _make_even(self) -> None:
        """Filter links from all that stands still if they are from some of it.

        pydrake's checker wants filters that are the same for all of a body.
        """
        world, pairs = {self.names[id] for id in self.standing}, self.pairs()
        for source, link, name in self.loaded.geometries:
            beside = sum(frozenset(((source, link, name), other)) in pairs for other in world)
            if source in self.loaded.robots and beside < len(world):
                same = [
                    i
                    for (s, k, _), i in self.loaded.geometries.items()
                    if (s, k) == (source, link)
                ]
                self.exclude(geometry.GeometrySet(same), geometry.GeometrySet(self.standing))

    def exclude(self, some: Any, others: Any = None) -> None:
        """Filter all pairs within a set, or between two."""
        declaration = geometry.CollisionFilterDeclaration()
        if others is None:
            declaration.ExcludeWithin(some)
        else:
            declaration.ExcludeBetween(some, others)
        self.scene_graph.collision_filter_manager().Apply(declaration)

    def pairs(self) -> set[frozenset[tuple[str, str, str]]]:
        """Return the unfiltered pairs."""
        found = self.scene_graph.model_inspector().GetCollisionCandidates()
        return {frozenset((self.names[a], self.names[b])) for a, b in found}

    def keep_only(self, pairs: set[frozenset[tuple[str, str, str]]]) -> None:
        """Filter what the other library filters."""
        ids = self.loaded.geometries
        for pair in self.pairs() - pairs:
            a, b = (geometry.GeometrySet([ids[name]]) for name in pair)
            self.exclude(a, b)

    def standing_poses(self) -> dict[tuple[str, str, str], Any]:
        """Return X_WG of what stands still, by name."""
        context = self.scene_graph.CreateDefaultContext()
        (posed,) = self.joints.poses(np.zeros((1, self.joints.count)))
        vector = geometry.FramePoseVector.FromArrays(self.joints.frame_ids, posed)
        context.UpdateFramePoses(vector)
        query = self.scene_graph.get_query_output_port().Eval(context)
        return {self.names[id]: query.X_WG(id) for id in self.standing}

    def states(self, count: int) -> np.ndarray:
        """Return random joint values (count, 16)."""
        rng = np.random.default_rng(0)
        return rng.uniform(self.joints.lower, self.joints.upper, (count, self.joints.count))
