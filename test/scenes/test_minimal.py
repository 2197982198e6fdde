from pathlib import Path

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

SCENES = Path(__file__).parents[2] / 'scenes'


def test_the_scene_of_the_readme_is_short_and_loads():
    path = SCENES / 'minimal.yaml'
    assert len(path.read_text().splitlines()) <= 10
    scene_graph = SceneGraph()
    loaded = load_scene(path, scene_graph)
    inspector = scene_graph.model_inspector()
    assert set(loaded.frames) == {('scene', 'ball')}
    assert inspector.NumAnchoredGeometries() == 2
    assert inspector.NumDynamicGeometries() == 1
