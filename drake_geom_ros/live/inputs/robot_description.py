"""A robot from a latched topic: the URDF or SDF on ``robot_description_topic`` becomes a source.

The source has the robot's name, its links are frames in the world that wait for their poses, and
adjacent links are filtered, as when a URDF is loaded from a file. The same text again changes
nothing. Another text takes the place of the one before: the scene is made anew without the old
robot and with the new one, or, where that cannot be, stays as it is. All else keeps its names,
properties, poses and persistent filters, but ids are new and transient filters are gone, as with
``load_scene`` and ``replace``.

A robot that the scene has already, with the same links and joints, is not added a second time: it
is followed, with the shapes, filters and poses of the scene.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.changes.together import together
from drake_geom_ros.live.scene.changes.world_change import without_matrix
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.same_robots import has_same_shapes, robot_of_scene
from drake_geom_ros.live.scene.scene_snapshot import SceneSnapshot
from drake_geom_ros.scene_files import (
    RobotTopics,
    SceneDescription,
    hulls_in_words,
    placed_robot,
    read_scene,
    robot_name,
    text_format,
    without_source,
)


class RobotInput:
    """Puts the robot of a description into the live scene, and another one in its place."""

    def __init__(self, live: LiveScene, topics: RobotTopics | None = None) -> None:
        """``topics``: with a name, a base and options of its own; None: those of the node."""
        self._live, self._topics = live, topics
        self._text = ''  # the URDF that is in the scene
        self._robot = ''  # its name there
        self._followed = ''  # the robot of the scene that it describes
        self._source = ''
        self._srdf = ''

    def take(self, text: str) -> str:
        """Take a URDF or SDF, and return what became of it, for the log.

        Raises RuntimeError for a text that is neither.
        """
        with self._live.reading() as scene:
            is_followed = self._followed in scene.model.robot_names()
            if text == self._text and (is_followed or self._is_in(scene)):
                return ''
        return self._put(text)

    def take_semantics(self, text: str) -> str:
        """Take an SRDF, which may come before its URDF; raises RuntimeError for none.

        Return what became of it, for the log.
        """
        name = _name_of(text)
        if text == self._srdf:
            return ''
        before, self._srdf = self._srdf, text
        with self._live.reading() as scene:
            is_in = self._is_in(scene)
            is_followed = self._followed in scene.model.robot_names()
        if is_followed and name == self._robot:
            return f'the SRDF of {name!r} is not read: {self._followed!r} has filters of its own'
        if not is_in:
            return f'the SRDF of {name!r} waits for its URDF'
        if name != self._robot:
            return f'the SRDF of {name!r} waits for its URDF; the robot is {self._robot!r}'
        try:
            return self._put(self._text, strict=True)
        except RuntimeError:
            self._srdf = before
            raise

    def _read(self, text: str, srdf: str) -> SceneDescription:
        """Return the robot that texts describe; a text has a line break, a path has none.

        Its frames wait for their poses, whatever a file of SDFormat says, but those that the file
        fixes to the world.
        """
        files, kind = self._live.files, text_format(text.encode(errors='surrogatepass'))
        own = self._topics
        robot = read_scene(
            *(f'{text}\n', kind, srdf and f'{srdf}\n', files.package_roots, files.folders),
            self._live.robot_options if own is None else own.options,
        )
        frames = (f if f.welded else replace(f, X_PF=None) for f in robot.frames)
        robot = replace(robot, frames=tuple(frames))
        return robot if own is None else _as_named(robot, own)

    def _put(self, text: str, *, strict: bool = False) -> str:
        """Put a robot into the scene, with the SRDF of its name.

        One that cannot be read is left away: another may still be on its way. ``strict``: it is
        refused. Of one with links that the robot does not have the rest counts, with a warning.
        """
        name = _name_of(text)
        srdf, note = self._srdf, ', pairs of its SRDF left out'
        if not srdf or _name_of(srdf) != name:
            srdf, note = '', ''
        try:
            robot = self._read(text, srdf)
        except RuntimeError as error:
            if not srdf or strict:
                raise
            robot = self._read(text, '')
            self._srdf, note = '', f', without its SRDF: {error}'
        if robot.warnings:
            note += f', {counted(len(robot.warnings), "warning")}'
        source = name if self._topics is None else self._topics.name
        with self._live.editing() as scene:
            is_in = self._is_in(scene)
            is_named = self._topics is not None
            if not is_in and len(robot.robots) == 1:
                same_robot = robot_of_scene(scene, robot, is_named=is_named)
                if same_robot:
                    return self._follow(scene, same_robot, name, text, robot)
            self._refuse_same_name(source, scene)
        if is_in:
            self._live.replace(partial(self._in_its_place, robot), self._source)
            done = f'replaces {self._source!r}'
        else:
            with self._live.reading() as scene:
                added = together(without_matrix(scene), addition(robot))
            self._live.change(added, calls_for_more=True)
            done = 'added'
        self._text, self._source, self._followed = text, source, ''
        self._robot = name
        return (
            f'robot {source!r} {done}: {len(robot.frames)} links, {len(robot.geometries)} shapes'
            f'{note}{hulls_in_words(robot.geometries)}'
        )

    def _follow(
        self, scene: HeldScene, same_robot: str, name: str, text: str, robot: SceneDescription
    ) -> str:
        """Leave a robot of the scene as it is, driven by the topic of its joints, if it has one.

        Return so in words.
        """
        self._text, self._robot, self._followed = text, name, same_robot
        topic = '' if self._topics is None else self._topics.joint_states
        (there,) = [each for each in scene.model.robots if each.name == same_robot]
        if topic and not there.joint_states:
            scene.model.route_joints(same_robot, topic)
        done = (
            f'robot {self._robot!r}: this is {same_robot!r} of the scene, which has the same '
            'links and joints; it is followed, and not added a second time'
        )
        if topic:
            done += f', with the joints of {there.joint_states or topic}'
        if not has_same_shapes(scene, same_robot, robot.geometries):
            done += '. Its shapes differ, and those of the scene count'
        return f'{done}. For another robot of this kind use the parameter robot_descriptions'

    def _in_its_place(self, robot: SceneDescription, before: SceneSnapshot) -> SceneDescription:
        """Return the scene of before with another robot in the place of the one that was there."""
        # Filters that wait for the robot, or waited for the one before, wait for this one.
        others = without_source(before.description(), self._source)
        return joined(replace(others, awaited=before.mark.awaited), robot)

    def _is_in(self, scene: HeldScene) -> bool:
        return self._source in _sources(scene)

    def _refuse_same_name(self, name: str, scene: HeldScene) -> None:
        """Raise ArgumentError where a source that is not the robot of before has the name."""
        if name in _sources(scene) - {self._source}:
            raise ArgumentError(
                f'the robot is called {name!r}, but the scene has a source of that name '
                'already, with other links or joints. If it is the same robot, remove it from the '
                "scene file, or start the node with robot_description_topic:=''; otherwise, "
                'rename one of them, or name this one by the parameter robot_descriptions'
            )


def _as_named(robot: SceneDescription, topics: RobotTopics) -> SceneDescription:
    """Return a robot with its joint topic, and its base where its topics have one.

    Raises ArgumentError for a model of SDFormat of another name, and RuntimeError for a pose of
    several root links.
    """
    if robot.sources != (topics.name,):
        raise ArgumentError(
            f'robot_descriptions calls the robot {topics.name!r}, and its SDFormat has the models '
            f'{", ".join(map(repr, robot.sources))}, which keep their names: call it as its model'
        )
    (described,) = robot.robots
    robot = replace(robot, robots=(replace(described, joint_states=topics.joint_states),))
    if topics.X_WB is None:
        return robot
    try:
        return placed_robot(robot, topics.X_WB)
    except ValueError as error:
        raise ArgumentError(str(error)) from error


def _name_of(text: str) -> str:
    """Return the name of the robot of a URDF, SDF or SRDF; raises RuntimeError for none."""
    return robot_name(text.encode(errors='surrogatepass'), '<text>')


def _sources(scene: HeldScene) -> set[str]:
    inspector = scene.model.inspector
    return set(map(inspector.GetName, inspector.GetAllSourceIds()))


def joined(first: SceneDescription, second: SceneDescription) -> SceneDescription:
    """Return a scene of two; what the second says is registered last."""
    names = ('sources', 'robots', 'frames', 'geometries', 'filters', 'warnings')
    return replace(first, **{name: getattr(first, name) + getattr(second, name) for name in names})
