"""A scene of its own that is made beside the cycles, to take the place of the live one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from drake_geom_ros.geometry import ArgumentError, SceneGraph, SceneGraphContext
from drake_geom_ros.live.conversions.names import MAPS
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.scene.scene_model import shared_context
from drake_geom_ros.live.scene.waiting_maps import WaitingMaps, waiting_maps
from drake_geom_ros.scene_files import LoadedScene, SceneDescription, register

HAS_MAPS = (
    f'the scene has a source {MAPS!r}, which is that of the sensed maps of this node; '
    'give it another name'
)


@dataclass(frozen=True)
class PreparedScene:
    """A scene graph with what was loaded into it.

    ``draft`` has its tables, where these were made ready, and ``maps`` wait in it.
    """

    scene_graph: SceneGraph
    context: SceneGraphContext  # shares it
    loaded: LoadedScene
    maps: WaitingMaps
    draft: SceneDraft | None = None


def prepared(
    description: SceneDescription,
    maps: Sequence[str] = (),
    margin: float = 0.0,
    accuracy: str = 'exact',
) -> PreparedScene:
    """Return what is described, its kernels compiled; raises RuntimeError for what cannot be.

    Takes long and holds nothing: so the live scene is replaced in a moment. ``maps`` wait in it,
    with a margin [m].
    """
    if maps and MAPS in description.sources:
        raise ArgumentError(HAS_MAPS)
    scene_graph = SceneGraph(accuracy=accuracy)
    loaded = register(scene_graph, description)
    waiting = WaitingMaps(None, {})
    if maps:
        waiting = waiting_maps(scene_graph, None, None, maps, margin)
    context = shared_context(scene_graph)
    context.UpdateFramePoses(loaded.first_poses)
    context.compile_kernels()
    return PreparedScene(scene_graph, context, loaded, waiting)
