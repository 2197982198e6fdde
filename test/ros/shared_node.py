"""One node and one client for all tests of a worker that need no node of their own.

They are in a ROS domain of their own, for nodes that tests start are named alike. After each file
the node is put back by its own services, and must answer like a fresh one.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from drake_geom_msgs import srv
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter
from ros.harness import Client, start_node
from ros.scene_calls import accepted

from drake_geom_ros.ros.parameters import QOS_OVERRIDES

_STEP = 18  # half of the step from one worker's domain to the next one's
_DOMAINS = 101  # 1 to 101, as ``run`` hands them out


@contextmanager
def domain_of_the_shared_node() -> Iterator[None]:
    """Let what is started and opened meanwhile be in the domain of the shared node."""
    before = os.environ.get('ROS_DOMAIN_ID')
    number = int(before or 1 + os.getpid() % 100)
    os.environ['ROS_DOMAIN_ID'] = str(1 + (number - 1 + _STEP) % _DOMAINS)
    try:
        yield
    finally:
        os.environ.pop('ROS_DOMAIN_ID')
        if before is not None:
            os.environ['ROS_DOMAIN_ID'] = before


class SharedNode:
    """A node that was started with nothing set, and a client of it."""

    def __init__(self, log: Path) -> None:
        self.process = start_node(log)
        self.client = Client()
        self._fresh = self.state()

    def close(self) -> None:
        """End the client and the node."""
        self.client.close()
        assert self.process.end() == 0, self.process.output()

    def load(self, text: str) -> None:
        """Put a scene in the place of the one that the node has."""
        self._call(srv.LoadScene, 'load_scene', text=text, replace=True)

    def set(self, **values: Any) -> None:
        """Set parameters."""
        self._put(
            [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        )

    def reset(self) -> None:
        """Put the node back; raise AssertionError where something is left of what tests did."""
        assert self.process.popen.poll() is None, f'the node died:\n{self.process.output()}'
        for rule in self.state()['rules']:  # they outlive the scene
            self._call(srv.RemoveProximityRule, 'remove_proximity_rule', name=rule)
        self.load('frames: []')
        fresh, now = self._fresh['parameters'], self._parameters()
        changed = [name for name in fresh if now[name] != fresh[name]]
        self._put([ParameterMessage(name=name, value=fresh[name]) for name in changed])
        left = {key: value for key, value in self.state().items() if value != self._fresh[key]}
        assert not left, f'left of what tests did: {left}'
        self._wait_until_untroubled()

    def state(self) -> dict[str, Any]:
        """Return what tests may change of the node."""
        filters = self._call(srv.GetFilters, 'get_filters')
        rules = self._call(srv.ListProximityRules, 'list_proximity_rules').states.rules
        return {
            'scene': self._call(srv.SaveScene, 'save_scene').text,
            'transient filters': list(filters.active_filter_ids),
            'transient history': filters.has_transient_history,
            'filtered pairs': filters.filtered_pairs,
            'rules': list(rules.name),
            'cameras': list(self._call(srv.ListCameras, 'list_cameras').cameras),
            'parameters': self._parameters(),
        }

    def _parameters(self) -> dict[str, ParameterValue]:
        # ROS has no service that takes back those that come with a topic.
        found = self.client.call(ListParameters, 'list_parameters').result.names
        names = [name for name in found if not name.startswith(QOS_OVERRIDES)]
        values = self.client.call(GetParameters, 'get_parameters', names=names).values
        return dict(zip(names, values, strict=True))

    def _put(self, parameters: list[ParameterMessage]) -> None:
        results = self.client.call(SetParameters, 'set_parameters', parameters=parameters).results
        assert all(result.successful for result in results), results

    def _wait_until_untroubled(self) -> None:
        """Wait for diagnostics that warn of nothing, as those of a fresh node."""
        messages = self.client.listen(DiagnosticArray, '/diagnostics')
        self.client.wait_for(
            lambda: messages and messages[-1].status[0].level == DiagnosticStatus.OK,
            'diagnostics that warn of nothing',
        )
        self.client.forget_topics()

    def _call(self, service_class: Any, service: str, /, **fields: Any) -> Any:
        return accepted(self.client.call(service_class, service, **fields))
