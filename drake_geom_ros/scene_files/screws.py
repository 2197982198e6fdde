"""Screw joints as a turn that a shift follows."""

import math
from dataclasses import replace

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.link_tree import Mimic, UrdfJoint


def screw_parts(joint: UrdfJoint, pitch: float) -> tuple[UrdfJoint, UrdfJoint]:
    """Return the two simple joints of a screw joint with a pitch [m] a turn.

    The turn has the name and the limits of the joint.
    """
    turn = replace(joint, type='revolute', parts=())
    shift = replace(
        turn,
        type='prismatic',
        name=f'{joint.name}/shift',
        X_PJ=RigidTransform(),
        lower=-math.inf,
        upper=math.inf,
        max_speed=math.inf,
        mimic=Mimic(joint.name, pitch / math.tau, 0.0),
    )
    return turn, shift
