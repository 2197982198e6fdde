"""The tables of a version of the scene: new after a change, and never changed themselves."""

import pytest
from live.live_scenes import TWO_BALLS, live_scene

from drake_geom_ros.geometry import GeometryFrame, Sphere
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.prepared_scene import prepared
from drake_geom_ros.scene_files import read_scene


@pytest.fixture
def live():
    return live_scene(TWO_BALLS)


def frame_added(scene, name):
    """Return the registration of a frame beside the two."""
    source = scene.model.names.source('s')
    frame = GeometryFrame(name)
    return Change(
        lambda graph, context: graph.RegisterFrame(
            context=context, source_id=source, parent_id=graph.world_frame_id(), frame=frame
        )
    )


def shape_changed(scene, *, same_content):
    """Return a change of a ball's size; with ``same_content`` as if it were a sensed map's."""
    source, ball = scene.model.owned_geometry('s::a/ball')
    return Change(
        lambda graph, context: graph.ChangeShape(
            context=context, source_id=source, geometry_id=ball, shape=Sphere(0.2)
        ),
        same_content=same_content,
    )


def made_at_once(live, change):
    with live.editing() as scene:
        return scene.make(change)


def made_on_a_draft(live, change):
    return live.change(change, calls_for_more=True)


@pytest.fixture(params=[made_at_once, made_on_a_draft])
def make(request):
    return request.param


def test_a_change_makes_new_tables_and_leaves_those_of_before(live, make):
    with live.reading() as scene:
        before, version = scene.model.names, scene.model.version
        change = frame_added(scene, 'late')
    frame = make(live, change)
    with live.reading() as scene:
        assert scene.model.names.frame('s::late') == frame
        assert scene.model.version == scene.model.names_version > version
    with pytest.raises(RuntimeError, match='no frame'):
        before.frame('s::late')


def test_cells_of_maps_grow_the_version_and_leave_the_tables(live, make):
    with live.reading() as scene:
        model = scene.model
        names, version, model_version = model.names, model.version, model.model_version
        change = shape_changed(scene, same_content=True)
    make(live, change)
    assert model.version > version
    assert model.model_version == model_version
    assert model.names is names


def test_another_shape_makes_another_model_of_the_same_names(live, make):
    with live.reading() as scene:
        model = scene.model
        model_version, names_version = model.model_version, model.names_version
        change = shape_changed(scene, same_content=False)
    make(live, change)
    assert model.model_version == model.version > model_version
    assert model.names_version == names_version


def test_a_change_that_fails_halfway_leaves_the_tables_as_the_scene_is(live):
    def registers_and_fails(graph, context):
        graph.RegisterSource('half')
        raise MemoryError

    with live.editing() as scene:
        with pytest.raises(MemoryError):
            scene.make(Change(registers_and_fails))
        assert scene.model.names.source('half').is_valid()


def test_another_scene_goes_on_counting_after_changes_of_cells(live):
    with live.editing() as scene:
        scene.make(shape_changed(scene, same_content=True))
        before = scene.model.version
        scene.replace(prepared(read_scene(TWO_BALLS)))
        assert scene.model.model_version == scene.model.version > before
        assert scene.query is scene.model.query
        assert scene.query.inspector().num_frames() == scene.model.inspector.num_frames() == 3
