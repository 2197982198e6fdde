"""What a scene is made of is all that its meshes name, too."""

import json

import pytest

from drake_geom_ros.geometry import (
    GeometryInstance,
    Mesh,
    PerceptionProperties,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import files_of

OBJ = """mtllib the look.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 2 3
f 1 2 4
f 1 3 4
f 2 3 4
"""
MTL = """newmtl one
Kd 1 0 0
map_Kd -s 1 1 1 skin.png
MAP_Ka absent.png
bump bump.png
"""


def names_of(mesh, role=ProximityProperties):
    graph = SceneGraph()
    source = graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(), Mesh(mesh), 'g')
    if role is PerceptionProperties:
        instance.set_perception_properties(role())
    else:
        instance.set_proximity_properties(role())
    graph.RegisterAnchoredGeometry(source, instance)
    return [path.name for path in files_of(graph, ())]


def test_materials_and_images_of_an_obj(tmp_path):
    (tmp_path / 'body.obj').write_text(OBJ)
    assert names_of(tmp_path / 'body.obj') == ['body.obj']  # what is not there is none
    (tmp_path / 'the look.mtl').write_text(MTL)
    for name in ('skin.png', 'bump.png', 'body.png', 'other.png'):
        (tmp_path / name).touch()
    found = names_of(tmp_path / 'body.obj')
    assert found == ['body.obj', 'the look.mtl', 'skin.png', 'bump.png', 'body.png']


def test_buffers_and_images_of_a_gltf(tmp_path):
    names = ['a%20b.bin', 'data:,x', 'absent.bin']
    document = {
        'asset': {'version': '2.0'},
        'buffers': [{'uri': name, 'byteLength': 1} for name in names] + [{'byteLength': 1}],
        'images': [{'uri': 'skin.png'}, {'bufferView': 0}],
    }
    (tmp_path / 'body.gltf').write_text(json.dumps(document))
    for name in ('a b.bin', 'skin.png'):
        (tmp_path / name).touch()
    found = names_of(tmp_path / 'body.gltf', PerceptionProperties)
    assert found == ['body.gltf', 'a b.bin', 'skin.png']


@pytest.mark.parametrize(
    'text', ['', '[', '[1]', '{"buffers": 3}', '{"buffers": [3, {"uri": 4}]}']
)
def test_what_is_no_gltf_names_nothing(tmp_path, text):
    (tmp_path / 'body.gltf').write_text(text)
    assert names_of(tmp_path / 'body.gltf', PerceptionProperties) == ['body.gltf']
