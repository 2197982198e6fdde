"""docs/inputs.md without ROS: its commands of TF put things where it says."""

import itertools
import re
import shlex
import time
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from conventions.source_tree import ROOT
from live.live_scenes import live_scene

from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.math import RigidTransform, RollPitchYaw

TEXT = (ROOT / 'docs/inputs.md').read_text()


def options(command):
    """Return the --name value pairs of a command."""
    words = shlex.split(command)
    pairs = itertools.pairwise(words)
    return {name.removeprefix('--'): value for name, value in pairs if name.startswith('--')}


def transform(told):
    """Return the TransformStamped that static_transform_publisher makes of its options."""
    numbers = {
        name: float(told.get(name, 0.0)) for name in ('x', 'y', 'z', 'roll', 'pitch', 'yaw')
    }
    rpy = [numbers[name] for name in ('roll', 'pitch', 'yaw')]
    X = RigidTransform(RollPitchYaw(rpy).ToRotationMatrix(), [numbers[a] for a in 'xyz'])
    x, y, z, qx, qy, qz, qw = X.ToArray().tolist()
    return Plain(
        header=Plain(frame_id=told['frame-id'], stamp=Plain(sec=1, nanosec=0)),
        child_frame_id=told['child-frame-id'],
        transform=Plain(translation=Plain(x=x, y=y, z=z), rotation=Plain(x=qx, y=qy, z=qz, w=qw)),
    )


@pytest.mark.parametrize('order', [1, -1])
def test_the_transforms_put_the_ball_where_the_text_says(order):
    commands = re.findall(r'static_transform_publisher (.*)$', TEXT, re.M)
    tf = TfInput(Clocks(time.time))
    live = live_scene(ROOT / 'scenes/minimal.yaml')
    for command in commands[::order]:
        with live.editing() as scene:
            tf.hear(Plain(transforms=[transform(options(command))]), static=True)
            tf.pose(scene)
    told = re.search(r'The ball is at x = (\S+), y = (\S+), z = (\S+) now', TEXT)
    view = live.view()
    position = view.query.X_WF(view.names.frame('ball')).translation()
    np.testing.assert_allclose(
        position, [float(number) for number in told.groups()], rtol=0, atol=1e-15
    )
