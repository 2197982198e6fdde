"""Comparison of a recorded ``robot_description`` with the robots of the scene."""

from __future__ import annotations

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.recordings.recording_topics import few_of
from drake_geom_ros.recordings.scene_differences import ComparedScene, table_of
from drake_geom_ros.scene_files import read_scene, register, robot_name, text_format

_HINT = 'the node takes that of the scene; --topic robot_description= says that they are the same'


class SceneRobots:
    """The robots of the scene at the start of a playback."""

    def __init__(self, live: LiveScene) -> None:
        """Note the sources of ``live``, before any recorded message changes it."""
        self._live = live
        self._same: set[str] = set()  # descriptions of robots that the scene has
        with live.reading() as scene:
            inspector = scene.model.inspector
            self._sources = {*map(inspector.GetName, inspector.GetAllSourceIds())}

    def has(self, text: str) -> bool:
        """Return whether the scene has the robot of a URDF.

        Raises RuntimeError if it has a different robot of the name, and for an invalid URDF.
        """
        if text in self._same:
            return True
        data = text.encode(errors='surrogatepass')
        name = robot_name(data, '<text>')
        if name not in self._sources:
            return False
        files = self._live.files
        described = read_scene(
            *(f'{text}\n', text_format(data), '', files.package_roots, files.folders),
            self._live.robot_options,
        )
        register(alone := SceneGraph(), described)
        with self._live.reading() as scene:
            own = _robot(table_of(scene.model.inspector), name)
        recorded = _robot(table_of(alone.model_inspector()), name)
        others = recorded.without(own) | own.without(recorded)
        others |= {each for each, _ in recorded.otherwise(own)}
        if others:
            raise RuntimeError(
                f'the robot {name!r} of the scene that was given is another than the recorded one '
                f'({few_of(sorted(others))}); {_HINT}'
            )
        self._same.add(text)
        return True


def _robot(table: ComparedScene, name: str) -> ComparedScene:
    """Return the geometries of a robot, without frames, whose parents a scene file may change."""
    own = {n: each for n, each in table.geometries.items() if n.startswith(f'{name}::')}
    return ComparedScene({}, own)
