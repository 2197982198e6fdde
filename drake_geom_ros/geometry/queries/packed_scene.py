"""The proximity geometry of a scene as arrays, which may go to another process."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.arrays import Bodies
from drake_geom_ros.geometry._contact_surfaces.packing import packed, packed_half_space
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.world.world import (
    FrameTable,
    GeometryTable,
    PointShapes,
    World,
)
from drake_geom_ros.geometry.errors import PoseError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.model.scene_content import SceneContent, proximity_keys_on
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.half_space_pairs import pairs_of_half_spaces
from drake_geom_ros.geometry.queries.padding import (
    Paddings,
)
from drake_geom_ros.geometry.queries.world_tables import know_point_shapes
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import WELDED_STAYS


@dataclass(frozen=True, eq=False)
class PackedScene:
    """The proximity geometry of a context as arrays, which may go to another process.

    Places identify frames and geometries. There are no ids, which are valid in one process only,
    so scenes of the same content have the same ``digest`` in every process.
    """

    parents: Indices  # (nf,) of the frames; the first is the world
    R_PFs: Floats  # (nf, 3, 3) poses of the frames that no state moves
    p_PFs: Floats  # (nf, 3) [m]
    frames: Indices  # (n,) of the geometries
    R_FGs: Floats  # (n, 3, 3)
    p_FGs: Floats  # (n, 3) [m]
    roundings: Floats  # (n, 2) of X_FG
    types: Indices  # (n,)
    starts: Indices  # (n + 1,) of the shapes' parameters
    pool: Floats
    # The shapes that points measure to; without queries about points, those above.
    point_types: Indices
    point_starts: Indices
    point_pool: Floats
    pairs: Indices  # (k, 2) that no filter leaves out
    moved: Indices  # the frames whose poses make a state
    paddings: Floats  # (n,) [m] of the geometries
    meshes: NDArray[np.bool_]  # (n,) True where points measure to the surface of a mesh
    half_spaces: Indices  # (m, 2) the pairs of them that no filter leaves out
    # The bodies of contact surfaces; without queries about these, none.
    body_of: Indices  # (n,) the row of each one's body; -1: it has none
    bodies: Bodies
    likeness: Indices  # (n,) of the bodies to the shapes in other queries: see ``contact_bodies``

    @classmethod
    def of(
        cls,
        context: SceneGraphContext,
        frame_ids: Indices,
        still: Mapping[int, Floats] | None = None,
        *,
        about_points: bool = True,
        about_contacts: bool = False,
        with_waiting: bool = False,
    ) -> tuple[PackedScene, Indices]:
        """Return a context's current scene, and its geometries' id values (n,) by place.

        ``frame_ids`` are id values of the frames that states pose, ``still`` the poses X_PF (7,)
        of those among them that are the same in each state: only such frames stay welded to the
        world. ``about_points`` adds the shapes that points measure to, ``about_contacts`` the
        contact bodies. ``with_waiting`` takes frames that never received a pose to be at their
        parents; the caller leaves their pairs out. Raises PoseError for a frame that is missing or
        listed twice, and, without ``with_waiting``, for other frames that have never received a
        pose.
        """
        state = state_of(context)
        world = state.up_to_date_world()
        if about_points:
            know_point_shapes(world, state.model)
        world = world.copy()
        named = world.named(frame_ids)
        if named is None or len(np.unique(frame_ids)) < len(frame_ids):
            is_known = world.has_frames(frame_ids)
            bad = frame_ids[~is_known].tolist() or sorted(frame_ids.tolist())
            problem = 'are not in this scene' if not is_known.all() else 'are not all different'
            raise PoseError(f'States were refused: these frames {problem}: {state.describe(bad)}.')
        rows = named.rows
        world.set_poses(rows, world.R_PFs[rows], world.p_PFs[rows])
        if with_waiting:
            _pose_waiting_frames(world)
        if waiting := world.unposed_frames().tolist():
            raise PoseError(
                'States were refused: these frames, which they do not name, never had a pose: '
                f'{state.describe(waiting)}.'
            )
        world.update()
        near = NeighbourList(world)
        filters = _unwelded(state, frame_ids, still or {})
        near.bring_up_to_date(world, filters, math.inf)
        table = world.geometries
        none = np.zeros(len(table.ids))
        body_of, bodies = np.full(len(table.ids), -1), packed([packed_half_space(0.0)])
        likeness = np.zeros(len(table.ids), dtype=np.int64)
        if about_contacts:
            contacts = state.contact_bodies()
            body_of, bodies, likeness = contacts.body_of, contacts.bodies, contacts.likeness
        paddings = state.paddings() or Paddings(none, none.astype(bool))
        # Each state replaces these poses, so they are no part of the content.
        R_PFs, p_PFs = world.R_PFs.copy(), world.p_PFs.copy()
        R_PFs[rows], p_PFs[rows] = np.eye(3), 0.0
        scene = cls(
            parents=world.frames.parents,
            R_PFs=R_PFs,
            p_PFs=p_PFs,
            frames=table.frames,
            R_FGs=table.R_FGs,
            p_FGs=table.p_FGs,
            roundings=table.roundings,
            types=table.types,
            starts=table.starts,
            pool=table.pool,
            point_types=world.point_shapes.types,
            point_starts=world.point_shapes.starts,
            point_pool=world.point_shapes.pool,
            pairs=near.pairs,
            moved=rows,
            paddings=paddings.radii,
            meshes=paddings.meshes,
            half_spaces=pairs_of_half_spaces(world, filters),
            body_of=body_of,
            bodies=bodies,
            likeness=likeness,
        )
        return scene, table.ids

    @property
    def digest(self) -> str:
        """A name for the content: the SHA-256 of all arrays."""
        digest = hashlib.sha256()
        for field in fields(self):
            value = getattr(self, field.name)
            for array in value if isinstance(value, Bodies) else (value,):
                digest.update(f'{field.name} {array.dtype.str} {array.shape}\n'.encode())
                digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def with_geometries(self, places: Indices) -> PackedScene:
        """Return the scene with some of its geometries alone, without pairs and contacts.

        Their places in it are their indices in ``places`` (k,).
        """
        none = np.zeros((0, 2), dtype=np.int64)
        starts, pool = _repacked(self.starts, self.pool, places)
        point_starts, point_pool = _repacked(self.point_starts, self.point_pool, places)
        rows = ('frames', 'R_FGs', 'p_FGs', 'roundings', 'types', 'point_types', 'paddings')
        own = {name: getattr(self, name)[places] for name in rows}
        return replace(
            self,
            **own,
            starts=starts,
            pool=pool,
            point_starts=point_starts,
            point_pool=point_pool,
            meshes=self.meshes[places],
            pairs=none,
            half_spaces=none,
            body_of=np.full(len(places), -1),
            likeness=np.zeros(len(places), dtype=np.int64),
        )

    def carriers(self) -> Indices:
        """Return the frame (n,) that states pose and that carries each geometry; 0: none does."""
        carriers = np.arange(len(self.parents))
        moved = np.isin(carriers, self.moved)
        for frame, parent in enumerate(self.parents.tolist()):
            if not moved[frame]:
                carriers[frame] = carriers[parent]
        return carriers[self.frames]

    def has_moving_pairs(self) -> bool:
        """Return whether any pair has a geometry on a frame that states pose, or a descendant."""
        pairs = np.concatenate((self.pairs, self.half_spaces))
        return bool((self.carriers()[pairs] > 0).any())

    def world(self) -> World:
        """Return a new world with a pose for every frame."""
        count = len(self.parents)
        world = World(
            FrameTable(np.arange(count), self.parents.copy()),
            GeometryTable(
                ids=np.arange(len(self.types)),
                frames=self.frames.copy(),
                R_FGs=self.R_FGs.copy(),
                p_FGs=self.p_FGs.copy(),
                roundings=self.roundings.copy(),
                types=self.types.copy(),
                starts=self.starts.copy(),
                pool=self.pool.copy(),
            ),
        )
        types, starts = self.point_types.copy(), self.point_starts.copy()
        kinds = frozenset(types.tolist())
        world.point_shapes = PointShapes(types, starts, self.point_pool.copy(), kinds)
        rows = np.arange(1, count)
        world.set_poses(rows, self.R_PFs[1:].copy(), self.p_PFs[1:].copy())
        return world


def _pose_waiting_frames(world: World) -> None:
    """Pose the frames that never received a pose at their parents."""
    absent = np.flatnonzero(np.isin(world.frames.ids, world.unposed_frames()))
    if count := len(absent):
        world.set_poses(absent, np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)))


def _repacked(starts: Indices, pool: Floats, places: Indices) -> tuple[Indices, Floats]:
    """Return starts (k + 1,) and parameters of the shapes at some places (k,)."""
    parts = [pool[starts[place] : starts[place + 1]] for place in places.tolist()]
    sizes = [len(part) for part in parts]
    firsts = np.concatenate(([0], np.cumsum(sizes, dtype=np.int64)))
    return firsts, np.concatenate((*parts, np.zeros(0)))


def _unwelded(
    content: SceneContent, frame_ids: Indices, still: Mapping[int, Floats]
) -> FilterState:
    """Return the filters without the welds of frames that states move from their place."""
    filters = content.filters
    moved = [
        frame
        for frame in filters.welded.keys() & set(frame_ids.tolist())
        if not _stays_welded(filters.welded[frame], still.get(frame))
    ]
    if moved:
        filters = filters.copy()
        for frame in moved:
            filters.unweld(frame, proximity_keys_on(content.model, FrameId(frame)))
    return filters


def _stays_welded(first: Floats | None, pose: Floats | None) -> bool:
    """Return whether a pose (7,) of all states equals the first one of a welded frame, if any."""
    if pose is None:
        return False
    _, (X_WF,) = arrays_of(FramePoseVector.FromArrays(np.ones(1, dtype=np.int64), pose[None]))
    return first is None or bool(np.abs(X_WF - first).max() <= WELDED_STAYS)
