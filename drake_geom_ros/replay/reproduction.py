"""Reproduction of the question of a replay file in the rebuilt scene."""

from __future__ import annotations

from drake_geom_ros.geometry import GeometryId, SceneGraph
from drake_geom_ros.replay.record import Answer, Name, Replay, answer_of
from drake_geom_ros.scene_files import LoadedScene, SceneFileError, load_scene


def reproduce(replay: Replay, file: str = '<replay>') -> Answer:
    """Return the answer of this version, with exactly the same poses, level and hint.

    Raises SceneFileError, naming ``file``, if the scene cannot be loaded or lacks the pair, and
    GeometryError if the query fails.
    """
    scene_graph, question = SceneGraph(), replay.question
    try:
        loaded = load_scene(f'{replay.scene}\n', scene_graph)
    except SceneFileError as error:
        raise SceneFileError(str(error), file, key='scene') from None
    # Other frames of the scene may have had no pose.
    context = scene_graph.CreateSharedContext(partial=True)
    a = _geometry(loaded, question.geometry_a, file)
    b = _geometry(loaded, question.geometry_b, file)
    if a == b:
        raise SceneFileError('geometry_a and geometry_b are the same', file, key='question')
    query = scene_graph.get_query_output_port().Eval(context)
    # Geometries are registered in the order of their ids, so that A remains the lower one.
    results = query.signed_distance_of_pair(a, b, accuracy=question.accuracy, hint=question.hint)
    return answer_of(results, 0)


def _geometry(loaded: LoadedScene, name: Name, file: str) -> GeometryId:
    if name not in loaded.geometries:
        source, frame, geometry = name
        raise SceneFileError(
            f"the scene has no geometry '{source}::{frame}/{geometry}' with the proximity role",
            file,
            key='question',
        )
    return loaded.geometries[name]
