"""Scenes of texts, as a page shows them."""

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import read_scene, register
from drake_geom_ros.viewing.local_scene import LocalScene

# A soft ball on a rigid table, and a bare one that has no part in it.
PRESSING = """
frames:
  - {name: ball, pose: {position: [0, 0, 0.045]}}
  - {name: bare, pose: {position: [0.2, 0, 0.045]}}
geometries:
  - {name: table, shape: {type: half_space},
     roles: {proximity: {hydroelastic: {compliance_type: rigid}}}}
  - {name: ball, frame: ball, shape: {type: sphere, radius: 0.05},
     roles: {proximity: {hydroelastic: {compliance_type: compliant, hydroelastic_modulus: 1e6,
     resolution_hint: 0.01}}}}
  - {name: bare, frame: bare, shape: {type: sphere, radius: 0.05}}
"""


def registered(text):
    """Return the scene graph of a text or a file."""
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(text))
    return scene_graph


def local_scene(text):
    """Return the shown scene of a text or a file."""
    scene_graph = registered(text)
    return LocalScene(scene_graph, scene_graph.CreateSharedContext(partial=True))
