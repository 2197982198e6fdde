"""Contact, distance and collision queries on scenes of geometry, in Python and as a ROS 2 node.

Start with ``drake_geom_ros.geometry``, which has the names of ``pydrake.geometry``: a
``SceneGraph``, shapes, and queries. ``scene_files`` loads robots and scenes into one,
``trajectories`` moves them, ``batch`` asks about many states, and ``recordings`` judges what ROS
recorded. None of these needs ROS. ``ros`` is the node, and ``client`` serves programs that use
one.
"""

from drake_geom_ros.version import VERSION

__version__ = VERSION
