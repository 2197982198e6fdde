"""Services of a node: a gripper may touch an object, takes it, and puts it down."""

from drake_geom_msgs import msg
from rclpy.callback_groups import ReentrantCallbackGroup
from std_srvs.srv import Trigger

from drake_geom_ros.client import (
    HeldFilter,
    RefusedError,
    Services,
    UnknownNameError,
    exclude_between,
)

_HELD = 'part off'
_LIMITS = {'level': msg.ProximityRule.STOP, 'enter': 0.05, 'leave': 0.06}  # [m]


class Gripper:
    """Serves ``~/expect_contact``, ``~/attach`` and ``~/release`` (Trigger) of its node."""

    def __init__(self, node):
        """``node`` has the parameters ``object``, and ``gripper``, the frame that takes it."""
        self._node = node
        self._object = node.declare_parameter('object', 'cell::part').value
        self._gripper = node.declare_parameter('gripper', 'ur5::tool0').value
        self._asked = Services(node, 'scene_graph')
        self._holding, self._attached = None, False
        waiting = ReentrantCallbackGroup()  # an answer waits for other answers
        for name in ('expect_contact', 'attach', 'release'):
            act = self._answering(getattr(self, f'_{name}'))
            node.create_service(Trigger, f'~/{name}', act, callback_group=waiting)

    def _answering(self, act):
        async def answer(_, response):
            try:
                response.message = await act()
                response.success = True
            except (RefusedError, UnknownNameError) as error:
                response.message = str(error)
            return response

        return answer

    async def _expect_contact(self):
        """Let the gripper's frame touch the object, on a lease that is renewed."""
        if self._holding is None:
            sets = (msg.GeometrySet(frames=[name]) for name in (self._gripper, self._object))
            declaration = msg.CollisionFilterDeclaration(statements=[exclude_between(*sets)])
            holding = HeldFilter(self._node, self._asked, declaration, self._lost)
            await holding.hold()
            self._holding = holding
        return f'{self._gripper} may touch {self._object}'

    async def _attach(self):
        """Have the object follow the gripper from where it is; to be called while both rest."""
        await self._expect_contact()
        await self._asked.ask('attach', frame=self._object, parent=self._gripper)
        if not self._attached:  # it is watched as the arm is, from what stands
            rule = msg.ProximityRule(name=_HELD, set_a=[self._object], set_b=['world'], **_LIMITS)
            await self._asked.ask('add_proximity_rule', rule=rule)
        self._attached = True
        return f'{self._object} follows {self._gripper}'

    async def _release(self):
        """Leave the object where it is; the gripper has the length of a lease to withdraw."""
        if self._attached:
            await self._asked.ask('detach', frame=self._object)
            await self._asked.ask('remove_proximity_rule', name=_HELD)
        self._attached = False
        if self._holding is not None:
            self._holding.let_run_out()
            self._holding = None
        return f'{self._object} stays where it is'

    def _lost(self):
        self._holding = None
        told = 'the filter is gone: the gripper must not touch the object'
        self._node.get_logger().warning(told)
