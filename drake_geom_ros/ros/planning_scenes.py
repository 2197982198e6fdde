"""MoveIt's planning scenes: what is asked at the start, what robots miss, and the way back."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from rclpy.publisher import Publisher

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.outputs import planning_scene
from drake_geom_ros.live.outputs.planning_scene import PlanningSceneTopic, PlanningSceneTypes
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.outputs.unlocked import LargePublisher
from drake_geom_ros.ros.surface import Surface

GET_PLANNING_SCENE = '/get_planning_scene'
_PERIOD = 0.1  # [s] between two looks
# All of PlanningSceneComponents but its settings, transforms and colours, which are not kept.
_COMPONENTS = 2 | 4 | 8 | 16 | 32 | 128 | 256


class SceneOutput(NamedTuple):
    """The topic of the scene as MoveIt has it: published while ``is_active()``."""

    publisher: Publisher
    did: Callable[[int, float], None]  # called with objects and seconds of a message
    is_active: Callable[[], bool]


class PlanningScenes:
    """Asks MoveIt for its scene once, when its service is there, and publishes this one."""

    def __init__(
        self,
        surface: Surface,
        live: LiveScene,
        guard: Guard,
        groups: CallbackGroups,
        taking: PlanningSceneInput,
        output: SceneOutput,
        log: Any,
    ) -> None:
        """Give what MoveIt answers to ``taking``; ``log`` is the logger of the node."""
        self._guard, self._taking, self._log = guard, taking, log
        kind = message_class('moveit_msgs/srv/GetPlanningScene')
        self._request = kind.Request()
        self._request.components.components = _COMPONENTS
        self._client = surface.client(kind, GET_PLANNING_SCENE, groups.loading)
        self._answer: Any = None
        self._is_asked = False
        self._is_active = output.is_active
        self._topic = PlanningSceneTopic(
            live,
            LargePublisher(output.publisher),
            _types(),
            surface.full_name(),
            lambda: taking.taken,
            output.did,
            log.warning,
        )
        attempt = partial(guard.attempt, self._look)
        surface.timer(_PERIOD, attempt, groups.loading)
        surface.timer(planning_scene.PERIOD, partial(guard.attempt, self.publish), groups.beside)

    def publish(self) -> None:
        """Publish the scene if somebody listens and it has changed."""
        if self._is_active():
            self._topic.publish()

    def _look(self) -> None:
        """Ask MoveIt if it is there, take what it answered, and pad robots that came since."""
        if not self._is_asked and self._client.service_is_ready():
            self._is_asked = True
            self._answer = self._client.call_async(self._request)
        if self._answer is not None and self._answer.done():
            answer, self._answer = self._answer, None
            self._guard.take(GET_PLANNING_SCENE.removeprefix('/'), self._take, answer)
        self._taking.renew()

    def _take(self, answer: Any) -> None:
        """Take an answer as a diff: what came by topics meanwhile, or of a file, stays."""
        scene = answer.result().scene
        scene.is_diff = scene.robot_state.is_diff = True
        done = self._taking.take_scene(scene)
        self._log.info(f'asked {GET_PLANNING_SCENE}: {done or "nothing new"}')


def _types() -> PlanningSceneTypes:
    """Return the classes of messages of MoveIt and of its shapes."""
    packages = {'Pose': 'geometry_msgs', 'Point': 'geometry_msgs'}
    shapes = 'SolidPrimitive', 'Mesh', 'MeshTriangle', 'Plane'
    packages |= dict.fromkeys(shapes, 'shape_msgs')
    return PlanningSceneTypes(
        *(
            message_class(f'{packages.get(name, "moveit_msgs")}/msg/{name}')
            for name in PlanningSceneTypes._fields
        )
    )
