"""A planar arm of balls among a box and a ball, which pydrake poses and answers exactly, too."""

import numpy as np
import pytest

from drake_geom_ros.batch import Checker, Joints
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

URDF = """<robot name="arm">
<link name="base"/>
<link name="upper"><collision name="elbow"><origin xyz="0.5 0 0"/>
<geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="lower"><collision name="hand"><origin xyz="0.5 0 0.02"/>
<geometry><sphere radius="0.08"/></geometry></collision></link>
<link name="tip"><collision name="tip"><origin xyz="0.3 0 0"/>
<geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="bend" type="revolute"><parent link="upper"/><child link="lower"/>
<origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" effort="1" velocity="1"/>
</joint>
<joint name="lift" type="prismatic"><parent link="lower"/><child link="tip"/>
<origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>
</joint>
</robot>"""
SCENE = """
name: planar
sources: [arm, things]
robots: [{name: arm, urdf: arm.urdf}]
geometries:
  - {name: box, source: things, pose: {position: [0.7, 0.6, 0]},
     shape: {type: box, size: [0.3, 0.2, 0.4]}}
  - {name: ball, source: things, pose: {position: [0.6, -0.7, 0.1]},
     shape: {type: sphere, radius: 0.15}}
"""


class Planar:
    """The scene, its joints and its checker."""

    def __init__(self, folder):
        (folder / 'arm.urdf').write_text(URDF)
        (folder / 'planar.yaml').write_text(SCENE)
        self.scene_graph = SceneGraph()
        self.loaded = load_scene(folder / 'planar.yaml', self.scene_graph)
        self.joints = Joints.of(self.loaded)
        self.checker = Checker(self.scene_graph, self.joints)
        self.geometries = {name: id for (_, _, name), id in self.loaded.geometries.items()}

    def states(self, count, seed=0):
        rng = np.random.default_rng(seed)
        return rng.uniform(self.joints.lower, self.joints.upper, (count, 3))


@pytest.fixture(scope='session')
def planar(tmp_path_factory):
    return Planar(tmp_path_factory.mktemp('planar'))
