"""The node `scene_viewer`: the page in the browser for a running scene_graph node."""

from __future__ import annotations

import sys
from typing import Any

from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.node import Node

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.ros.parameters import ParameterRefusedError, declared, unknown_parameters
from drake_geom_ros.ros.spinning import run_node
from drake_geom_ros.ros.usage import is_help, usage
from drake_geom_ros.ros.viewer.node_scene import NodeScene
from drake_geom_ros.viewing.page.page import Page
from drake_geom_ros.viewing.page.serving import LOCALHOST, PORT, open_server, warning

_REFUSALS = (ParameterRefusedError, GeometryError)
_TEXTS = {
    'server': 'Name of the node that is looked at.',
    'host': 'Address that the page is served at; 127.0.0.1: this machine only.',
    'port': 'Port of the page; where it is taken, the next free one.',
    'max_distance': 'Pairs farther apart are left out [m], until the slider is moved.',
}


class SceneViewer(Node):
    """Serves the page while it is spun."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('scene_viewer', **kwargs)
        server = self._declare('server', '/scene_graph')
        host = self._declare('host', LOCALHOST)
        port = self._declare('port', PORT, IntegerRange(from_value=1, to_value=65535))
        max_distance = self._declare('max_distance', 0.1)
        for text in unknown_parameters(self):
            self.get_logger().warning(text)
        self.scene = NodeScene(self, server)
        self.page = Page(
            open_server(host, port),
            self.scene,
            max_distance=max(0.0, max_distance),
            title=server.strip('/'),
            log=self.get_logger().error,
        )
        self.get_logger().info(f'http://{self.page.host}:{self.page.port} shows {server}')
        if text := warning(host):
            self.get_logger().warning(text)
            # Not to the log, which goes to files and to every ROS process that listens.
            print(self.page.url, flush=True)

    def destroy_node(self) -> None:
        """Close the page, too, if it was opened."""
        if hasattr(self, 'page'):
            self.page.close()
        super().destroy_node()

    def _declare(self, name: str, default: object, limits: IntegerRange | None = None) -> Any:
        descriptor = ParameterDescriptor(
            description=_TEXTS[name],
            read_only=True,
            integer_range=[] if limits is None else [limits],
        )
        return declared(self, name, default, descriptor)


def main(args: list[str] | None = None) -> int:
    """Run the viewer until it is interrupted; return 2 where no page can be opened."""
    if is_help(args):
        print(
            usage(
                'scene_viewer',
                example='[-p server:=/scene_graph]',
                description='Serves a page in the browser with the scene of a running node.',
                texts=_TEXTS,
                see='docs/viewing.md describes the page.',
            )
        )
        return 0
    return run_node(SceneViewer, _REFUSALS, args)


if __name__ == '__main__':
    sys.exit(main())
