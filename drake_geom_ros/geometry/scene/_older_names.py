"""Part of ``SceneGraph`` with older names of pydrake."""

from __future__ import annotations

from drake_geom_ros.geometry.model.collision_filter_declaration import CollisionFilterDeclaration
from drake_geom_ros.geometry.model.collision_filter_manager import CollisionFilterManager
from drake_geom_ros.geometry.model.geometry_set import GeometrySet
from drake_geom_ros.geometry.model.scene_content import SceneContent, SceneHolder
from drake_geom_ros.geometry.scene._or_on_context import or_on_context


class OlderNames(SceneHolder):
    """A scene graph with the methods of 2020 for filter declarations."""

    @or_on_context
    def ExcludeCollisionsWithin(self, on: SceneContent, set: GeometrySet) -> None:
        """Exclude all pairs within a set; the older form of a persistent declaration."""
        declaration = CollisionFilterDeclaration().ExcludeWithin(set)
        CollisionFilterManager(on.model, on.filters).Apply(declaration)

    @or_on_context
    def ExcludeCollisionsBetween(
        self, on: SceneContent, setA: GeometrySet, setB: GeometrySet
    ) -> None:
        """Exclude all pairs between two sets; the older form of a persistent declaration."""
        declaration = CollisionFilterDeclaration().ExcludeBetween(setA, setB)
        CollisionFilterManager(on.model, on.filters).Apply(declaration)
