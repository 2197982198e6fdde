"""Stopping: whether robots that begin to brake now stand before they touch anything.

The answer is certified for all times of the motion, and for everything that may come towards them
meanwhile. Nothing here has a safety rating.
"""

from drake_geom_ros.stopping.braking import Braking, BrakingError, StopCategory
from drake_geom_ros.stopping.robots import Robot, RobotState, robots_of
from drake_geom_ros.stopping.stop import RESOLUTION, Stop, StoppingQuestion
from drake_geom_ros.stopping.stopping_check import StoppingCheck
from drake_geom_ros.stopping.unmapped import FindUnmapped, Unmapped

__all__ = [
    'RESOLUTION',
    'Unmapped',
    'Braking',
    'BrakingError',
    'FindUnmapped',
    'Robot',
    'RobotState',
    'Stop',
    'StopCategory',
    'StoppingCheck',
    'StoppingQuestion',
    'robots_of',
]
