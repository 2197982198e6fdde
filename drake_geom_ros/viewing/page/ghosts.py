"""Ghosts: robots drawn faintly at places on the way of the stop from their present speed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.viewing.batches import SurfaceBatch, batches_of
from drake_geom_ros.viewing.page.options import ViewOptions
from drake_geom_ros.viewing.shown_scene import Ghost, ShownGeometries, ShownMoment

_OPACITY = 0.2
_COLOUR = (255, 110, 30)


class Ghosts:
    """Drawer of ghosts, which are made anew where other bodies move."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._geometries: ShownGeometries | None = None
        self._ids: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._shown: list[tuple[SurfaceBatch, list[Any]]] = []  # with a node for each ghost

    def show(self, moment: ShownMoment, options: ViewOptions) -> None:
        """Draw the ghosts of a moment, in the layers that are shown."""
        ghosts = moment.ghosts
        ids = np.unique(np.concatenate([self._ids[:0], *(ghost.ids for ghost in ghosts)]))
        is_same = moment.geometries is self._geometries and np.array_equal(ids, self._ids)
        if not is_same or any(len(nodes) != len(ghosts) for _, nodes in self._shown):
            self._begin(moment.geometries, ids, len(ghosts), options.hidden)
        for batch, nodes in self._shown:
            for ghost, node in zip(ghosts, nodes, strict=True):
                node.visible = batch.layer in options.layers
                R_WGs, p_WGs = _poses(moment, ghost)
                node.batched_positions, node.batched_wxyzs = batch.posed(R_WGs, p_WGs)

    def _begin(
        self,
        geometries: ShownGeometries,
        ids: NDArray[np.int64],
        count: int,
        hidden: frozenset[str],
    ) -> None:
        """Draw ghosts of other bodies from now on."""
        for _, nodes in self._shown:
            for node in nodes:
                node.remove()
        self._geometries, self._ids = geometries, ids
        moving = set(ids.tolist())
        looks = [
            replace(look, colour=(*look.colour[:3], _OPACITY))
            for look in geometries.looks
            if look.geometry.get_value() in moving and look.name.partition('::')[0] not in hidden
        ]
        batches = batches_of(looks, geometries.row_of).batches
        self._shown = [
            (batch, [self._node(number, k, batch) for k in range(count)])
            for number, batch in enumerate(batches)
        ]

    def _node(self, number: int, ghost: int, batch: SurfaceBatch) -> Any:
        count = len(batch.bodies)
        return self._scene.add_batched_meshes_simple(
            f'/ghosts/{number}/{ghost}',
            vertices=batch.surface.vertices,
            faces=batch.surface.triangles,
            batched_wxyzs=np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
            batched_positions=np.zeros((count, 3)),
            batched_scales=batch.scales,
            batched_colors=np.tile(np.array(_COLOUR, dtype=np.uint8), (count, 1)),
            opacity=_OPACITY,
            flat_shading=not batch.surface.smooth,
            side='double' if batch.surface.two_sided else 'front',
            lod='off',
            cast_shadow=False,
            receive_shadow=False,
        )


def _poses(moment: ShownMoment, ghost: Ghost) -> Any:
    """Return R_WG (k, 3, 3) and p_WG (k, 3) of all shown geometries, those of a ghost there."""
    R_WGs, p_WGs = np.array(moment.R_WGs), np.array(moment.p_WGs)
    rows = np.searchsorted(moment.geometries.ids, ghost.ids)
    R_WGs[rows], p_WGs[rows] = ghost.R_WGs, ghost.p_WGs
    return R_WGs, p_WGs
