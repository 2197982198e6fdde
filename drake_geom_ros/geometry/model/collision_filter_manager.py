"""``CollisionFilterManager``: declares, removes and explains collision filters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.filters.groups import UNIVERSAL
from drake_geom_ros.geometry._proximity.filters.log import FilterOperation, Statement
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry.checks import canonical_name, checked_type
from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError, FilterError, RoleError
from drake_geom_ros.geometry.ids import FilterId, FrameId, GeometryId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.collision_filter_declaration import (
    CollisionFilterDeclaration,
    SetSnapshot,
)
from drake_geom_ros.geometry.model.geometry_set import GeometrySet
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.scene_content import proximity_keys_on


class FilterStatement(NamedTuple):
    """A statement of a persistent declaration, resolved to geometries."""

    operation: FilterOperation
    set_A: list[GeometryId]
    set_B: list[GeometryId]  # empty for ExcludeWithin and AllowWithin


class FilterGroup(NamedTuple):
    """A collision filter group: its members, and the names of the groups that it ignores."""

    members: list[GeometryId]
    ignored: list[str]


class CollisionFilterManager:
    """A view of the collision filters of a SceneGraph, or of a context of one.

    ``SceneGraph.collision_filter_manager(context=None)`` returns it. It changes the set C of the
    pairs that proximity queries report::

        C = (G x G) - (A x A) - F - I

    G are the geometries with the proximity role, A x A the pairs of anchored ones (on the world
    frame, or on one that is welded to it: ``WeldToWorld``), F those on one frame, I those of a
    geometry with itself. Pairs of the last three can never be put into C; a declaration that tries
    has no effect on them. Further rules:

    - The last statement about a pair wins. Declarations, groups and cliques follow one another in
      the persistent base; transient declarations follow these in the order of their ids.
    - A frame in a set stands for its current geometries with the proximity role; later ones start
      unfiltered, and geometries without the role are ignored.
    - The base cannot change while there are transient declarations, since a change might have no
      effect: remove them, or ``Flatten``. ``Activate`` and ``Deactivate`` override all
      declarations, so they are always possible.
    - An unknown id raises RuntimeError, and nothing changes.

    Source of these rules: Drake's CollisionFilterManager. Groups, cliques, activation, flatten
    and explanations are additions of this package, as are changes of groups after loading.
    """

    def __init__(self, model: Model, filters: FilterState) -> None:
        self._model = model
        self._filters = filters

    # As in pydrake.

    def Apply(self, declaration: CollisionFilterDeclaration) -> None:
        """Apply a declaration to the persistent base.

        Raises FilterError while there are transient declarations, UnknownIdError for ids.
        """
        self._check_no_history('Apply')
        self._filters.apply(self._statements(declaration, 'Apply'))

    def ApplyTransient(self, declaration: CollisionFilterDeclaration) -> FilterId:
        """Apply a declaration on top of all others, and return the id for its removal.

        Raises UnknownIdError for ids.
        """
        statements = self._statements(declaration, 'ApplyTransient')
        filter_id = FilterId.get_new_id()
        self._filters.apply_transient(statements, filter_id.get_value())
        return filter_id

    def RemoveDeclaration(self, filter_id: FilterId) -> bool:
        """Remove a transient declaration, and return whether it was active.

        C becomes as if the declaration had never been made.
        """
        return self.IsActive(filter_id) and self._filters.remove_declaration(filter_id.get_value())

    def IsActive(self, filter_id: FilterId) -> bool:
        """Return whether a transient declaration is in the history."""
        checked_type(filter_id, FilterId, 'filter_id')
        return filter_id.is_valid() and self._filters.is_active(filter_id.get_value())

    def has_transient_history(self) -> bool:
        """Return whether there are transient declarations."""
        return self._filters.has_transient_history

    # Additions to pydrake: the history, and deactivated geometries.

    def RemoveDeclarations(self, filter_ids: Iterable[FilterId]) -> list[FilterId]:
        """Remove transient declarations at once, and return those that were active.

        The effect is that of ``RemoveDeclaration`` for each, in one pass over the history.
        """
        values = [filter_id.get_value() for filter_id in filter_ids if self.IsActive(filter_id)]
        return [FilterId(value) for value in self._filters.remove_declarations(values)]

    def Flatten(self) -> None:
        """Make the current C the persistent base; no transient declaration is active then."""
        self._filters.flatten()

    def Activate(self, geometry_set: GeometrySet) -> None:
        """Undo ``Deactivate``: geometries are reported again, as far as declarations allow."""
        self._filters.activate(self._keys(geometry_set))

    def Deactivate(self, geometry_set: GeometrySet) -> None:
        """Exclude geometries from all pairs until they are activated; overrides declarations."""
        self._filters.deactivate(self._keys(geometry_set))

    def WeldToWorld(self, frame_ids: Iterable[FrameId]) -> None:
        """Count geometries on frames, now and later, among the anchored ones.

        For links that fixed joints connect to the world: they keep their frames, and the first
        pose defines their place. A later pose that differs by more than 1e-6, in metres or in R,
        ends the weld in that context, and the pairs are reported from then on. Raises
        UnknownIdError for an unknown frame, ArgumentError for one whose parent is not the world.
        """
        frames = [self._model.frame(frame_id) for frame_id in frame_ids]
        for frame in frames:
            if frame.parent_id != self._model.world_frame_id or frame.id == frame.parent_id:
                raise ArgumentError(
                    f"WeldToWorld: the parent of the frame '{frame.name}' ({frame.id!r}) must be "
                    'the world'
                )
        for frame in frames:
            self._filters.weld(frame.id.get_value(), proximity_keys_on(self._model, frame.id))

    def welded_frames(self) -> list[FrameId]:
        """Return the frames that are welded to the world."""
        return [FrameId(value) for value in self._filters.welded]

    def deactivated_geometries(self) -> list[GeometryId]:
        """Return the geometries that are deactivated, ascending."""
        return _ids(self._filters.deactivated())

    def active_filter_ids(self) -> list[FilterId]:
        """Return the ids of the transient declarations, in the order of their application."""
        return [FilterId(value) for value in self._filters.active_ids]

    # Additions to pydrake: groups and cliques.

    @staticmethod
    def universal_group_name() -> str:
        """Return the name of the group that all geometries belong to, in every scene."""
        return UNIVERSAL

    def AddGroup(
        self, name: str, members: GeometrySet, ignored_groups: Iterable[str] = ()
    ) -> None:
        """Define a collision filter group, or add members and ignored groups to it.

        Pairs of a member and a member of a group that it ignores are taken out of C. All
        geometries belong to the group ``universal``: the members of a group that ignores it are
        in no pair, not even with geometries that are added later. A group may ignore one that does
        not exist yet; this takes effect with the definition of the latter.

        Raises ArgumentError for a bad name, UnknownIdError for a member that does not exist,
        FilterError while there are transient declarations.
        """
        name = canonical_name(name, 'AddGroup')
        if isinstance(ignored_groups, str):
            raise ArgumentTypeError(f'AddGroup: ignored_groups = {ignored_groups!r} must be names')
        ignored = [canonical_name(other, 'AddGroup: ignored_groups') for other in ignored_groups]
        if name == UNIVERSAL:
            raise ArgumentError(
                f'AddGroup: {UNIVERSAL!r} is the group that all geometries belong to; it can be '
                'ignored, not defined. Choose another name'
            )
        self._check_no_history('AddGroup')
        self._filters.add_group(name, self._keys(members), ignored)

    def AddClique(self, name: str, members: GeometrySet) -> None:
        """Define a clique, or add members to it: pairs of its members are taken out of C.

        Raises ArgumentError for a bad name, UnknownIdError for a member that does not exist,
        FilterError while there are transient declarations.
        """
        self._add_cliques([(name, members)], 'AddClique')

    def AddCliques(self, cliques: Iterable[tuple[str, GeometrySet]]) -> None:
        """Define cliques by names, or add members to them: all, or none where one is refused.

        As ``AddClique`` for each, and faster for the thousands of a large robot. Raises as that
        does.
        """
        self._add_cliques(cliques, 'AddCliques')

    def filter_groups(self) -> dict[str, FilterGroup]:
        """Return the groups by name, in the order of their definition."""
        groups = self._filters.groups
        return {
            name: FilterGroup(_ids(groups.members(name)), groups.ignored(name))
            for name in groups.names()
        }

    def group_masks(self, geometry_id: GeometryId) -> tuple[int, int]:
        """Return the bit masks (membership, ignore) of a geometry with the proximity role.

        Bit 0 is the universal group, the others follow in the order of being first named.
        """
        key = self._key(geometry_id)
        return self._filters.groups.membership(key), self._filters.groups.ignore(key)

    def cliques(self) -> dict[str, list[GeometryId]]:
        """Return the members of each clique by its name."""
        return {name: _ids(members) for name, members in self._filters.cliques().items()}

    # Additions to pydrake: explanations.

    def explain(self, geometry_id_A: GeometryId, geometry_id_B: GeometryId) -> list[str]:
        """Return the reasons why a pair is not in C, an empty list if it is.

        Each reason is sufficient: ``self``, ``anchored``, ``same frame``, ``deactivated``,
        ``group NAME``, ``clique NAME``, ``persistent declaration N`` (counted from 0 in the
        order of ``Apply``) and ``transient declaration ID``. Raises UnknownIdError, or
        RoleError for a geometry without the proximity role.
        """
        return self._filters.explain(self._key(geometry_id_A), self._key(geometry_id_B))

    def num_filtered_pairs(self) -> int:
        """Return the number of pairs that are not in C but could be."""
        return self._filters.filtered_pairs()

    def declarations(self) -> list[list[FilterStatement]]:
        """Return persistent declarations that, after the groups and cliques, produce the base.

        Exclusions by a group or a clique after the first declaration are repeated in their place.
        Declarations without any remaining effect may be missing.
        """
        return [
            [FilterStatement(operation, _ids(a), _ids(b)) for operation, a, b in statements]
            for statements in self._filters.declarations()
        ]

    # Helpers.

    def _add_cliques(self, cliques: Iterable[tuple[str, GeometrySet]], what: str) -> None:
        named = [(canonical_name(name, what), self._keys(members)) for name, members in cliques]
        self._check_no_history(what)
        self._filters.add_cliques(named)

    def _check_no_history(self, what: str) -> None:
        if self._filters.has_transient_history:
            raise FilterError(
                f'{what}: the persistent filters cannot change while the transient declarations '
                f'{self._filters.active_ids} are active. Remove these (RemoveDeclaration), '
                'Flatten, or use ApplyTransient'
            )

    def _statements(self, declaration: CollisionFilterDeclaration, what: str) -> list[Statement]:
        """Return the statements of a declaration, resolved; UnknownIdError for an unknown id."""
        checked_type(declaration, CollisionFilterDeclaration, f'{what}: declaration')
        return [
            (operation, self._resolved(set_A), self._resolved(set_B))
            for operation, set_A, set_B in declaration._statements
        ]

    def _resolved(self, members: SetSnapshot) -> tuple[int, ...]:
        if not members.frames and self._filters.knows(members.geometries):
            return members.geometries  # the common case, ten times as fast as resolving each
        ids = [GeometryId(value) for value in members.geometries]
        return _values(self._model.resolve_members(ids, members.frames, Role.kProximity))

    def _keys(self, geometry_set: GeometrySet) -> tuple[int, ...]:
        return _values(self._model.resolve(geometry_set, Role.kProximity))

    def _key(self, geometry_id: GeometryId) -> int:
        record = self._model.geometry(geometry_id)
        if record.proximity is None:
            raise RoleError(
                f"The geometry '{record.name}' ({geometry_id!r}) has no collision filters, for "
                'it has no proximity role. See SceneGraph.AssignRole'
            )
        return geometry_id.get_value()


def _values(ids: Iterable[GeometryId]) -> tuple[int, ...]:
    return tuple([geometry_id.get_value() for geometry_id in ids])


def _ids(keys: Iterable[int]) -> list[GeometryId]:
    return [GeometryId(key) for key in keys]


# Reasons that no declaration can override; see ``FilterState.explain``.
_FOR_GOOD = {
    'self': 'a geometry has no distance from itself',
    'anchored': 'both stand on the world, and never move against each other',
    'same frame': 'both are on one frame, and never move against each other',
}


def how_to_allow(reasons: list[str]) -> str:
    """Return advice on how to allow a pair that is filtered for these reasons, if possible."""
    for reason, why in _FOR_GOOD.items():
        if reason in reasons:
            return f'No filter can allow it: {why}.'
    return 'See CollisionFilterManager for how to allow it.'
