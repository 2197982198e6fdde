"""Names and ids of a scene, and what is said of those that it does not hold; without ROS."""

import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry import GeometryFrame, SceneGraph
from drake_geom_ros.live.conversions.names import NameTable, UnknownNameError, some_of


@pytest.fixture
def scene():
    """Two sources; both have a frame ``hand``, one has a frame called as the world."""
    scene = SceneGraph()
    for name, frames in (('left', ('hand', 'tool')), ('right', ('hand', 'world'))):
        source = scene.RegisterSource(name)
        for frame in frames:
            frame_id = scene.RegisterFrame(source, GeometryFrame(frame))
            scene.RegisterGeometry(source, frame_id, instance('ball'))
        scene.RegisterAnchoredGeometry(source, instance(f'{name} floor'))
    return scene


@pytest.fixture
def names(scene):
    return NameTable(scene.model_inspector(), 'map')


def test_short_names_do_where_they_are_unique(names):
    assert names.frame('tool') == names.frame('left::tool')
    assert names.geometry('tool/ball') == names.geometry('left::tool/ball')
    assert names.geometry('world/left floor') == names.geometry('left::world/left floor')
    with pytest.raises(
        UnknownNameError, match=r"2 frames share the name 'hand': 'left::hand' \(#\d+\)"
    ):
        names.frame('hand')
    assert names.frame('hand', 'left') == names.frame('left::hand')
    with pytest.raises(UnknownNameError, match="no frame 'right::tool'"):
        names.frame('tool', 'right')


@pytest.mark.parametrize('source', ['', 'left', 'right'])
def test_the_name_of_the_world_is_the_world_whoever_else_bears_it(scene, names, source):
    assert names.frame('world', source) == names.frame('map', source) == scene.world_frame_id()
    assert names.frame('right::world') != scene.world_frame_id()


def test_what_is_anchored_is_found_under_either_name_of_the_world(names):
    floor = names.geometry('left::world/left floor')
    for name in ('map/left floor', 'left::map/left floor', 'world/left floor'):
        assert names.geometry(name) == floor
    with pytest.raises(UnknownNameError):
        names.geometry('right::map/left floor')
    # What is on a frame called `world` is not on the world.
    assert names.geometry('right::world/ball') != floor
    with pytest.raises(UnknownNameError):
        names.geometry('map/ball')


def test_ids(names):
    tool = names.frame('tool')
    assert names.frame(f'#{tool.get_value()}') == tool
    for name in ('#0', '#-1', '#', '#99999999999999999999', '#x', '#²', f'#{"9" * 5000}'):
        with pytest.raises(UnknownNameError, match='There is no frame'):
            names.frame(name)


def test_a_long_name_is_not_repeated_whole(names):
    with pytest.raises(UnknownNameError) as caught:
        names.geometry('n' * 10**6)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    ('kind', 'name', 'hint'),
    [
        ('frame', 'toll', "There is no frame 'toll' in the scene; nearest: 'tool'."),
        ('frame', 'left::TOOL', "; nearest: 'left::tool'"),
        ('frame', 'tool/ball', '; that is a geometry.'),
        ('geometry', 'tool/bal', "; nearest: 'tool/ball'"),
        ('geometry', 'tool', "; that is a frame, and on it there is 'tool/ball'."),
        (
            'geometry',
            'map',
            "; that is a frame, and on it there is 'map/left floor', 'map/right floor'.",
        ),
        ('geometry', 'zzz', "There is no geometry 'zzz' in the scene. It holds"),
        ('source', 'lefd', "There is no source 'lefd'; nearest: 'left'"),
    ],
)
def test_what_is_unknown_comes_with_what_may_be_meant(names, kind, name, hint):
    for _ in range(2):  # the second one is remembered
        with pytest.raises(UnknownNameError) as caught:
            getattr(names, kind)(name)
        assert hint in str(caught.value)


def test_of_many_names_a_few_are_told_and_of_a_long_one_its_beginning():
    assert some_of(['a', 'b', 'c'], 2) == 'a, b ...'
    assert some_of([1, 'n' * 80]) == f'1, {"n" * 80}'
    assert some_of(['n' * 10**6, 'b']) == f'{"n" * 77}..., b'


def named_scene(*pairs):
    """Return a scene of frames by (source, name), with a ball on each, and the frames' ids."""
    scene, sources, frames = SceneGraph(), {}, {}
    for source, name in pairs:
        if source not in sources:
            sources[source] = scene.RegisterSource(source)
        frames[source, name] = scene.RegisterFrame(sources[source], GeometryFrame(name))
        scene.RegisterGeometry(sources[source], frames[source, name], instance('ball'))
    return scene, frames


def test_names_that_hold_colons_are_found_by_source_and_name_and_never_split():
    scene, frames = named_scene(('a', 'b::c'), ('a::b', 'c'), ('x', 'c'))
    names = NameTable(scene.model_inspector())
    assert names.frame('b::c', 'a') == names.frame('b::c') == frames['a', 'b::c']
    assert names.frame('c', 'a::b') == frames['a::b', 'c']
    with pytest.raises(UnknownNameError, match="2 frames share the name 'a::b::c'"):
        names.frame('a::b::c')
    assert names.frame('a::b::c', 'a') == frames['a', 'b::c']
    with pytest.raises(UnknownNameError, match="frame 'x::c' does not belong to source 'a'"):
        names.frame('x::c', 'a')
    assert names.frames_called('x::c') == []
    assert names.frames_called('c') == [frames['a::b', 'c'], frames['x', 'c']]


def test_a_frame_called_as_the_id_of_another_is_refused():
    scene, frames = named_scene(('a', 'b'))
    value = frames['a', 'b'].get_value()
    source = scene.RegisterSource('s')
    own = scene.RegisterFrame(source, GeometryFrame(f'#{value}'))
    free = scene.RegisterFrame(source, GeometryFrame('#18446744073709551615'))
    names = NameTable(scene.model_inspector())
    with pytest.raises(UnknownNameError, match=f"2 frames share the name '#{value}'.*'a::b'"):
        names.frame(f'#{value}')
    assert names.frame(f'#{value}', 's') == names.frame(f's::#{value}') == own
    assert names.frame(f'#{value}', 'a') == frames['a', 'b']
    assert names.frame('#18446744073709551615') == free


def test_a_world_frame_that_looks_like_a_full_name():
    scene, _ = named_scene(('s', 'arm'))
    source = scene.RegisterSource('t')
    floor = scene.RegisterAnchoredGeometry(source, instance('floor'))
    names = NameTable(scene.model_inspector(), 't::world')
    assert names.geometry('t::world/floor') == names.geometry('world/floor') == floor
    names = NameTable(scene.model_inspector(), 's::arm')
    with pytest.raises(UnknownNameError, match="2 frames share the name 's::arm'"):
        names.frame('s::arm')


def test_a_source_called_as_the_id_of_another_is_refused():
    scene = SceneGraph()
    first = scene.RegisterSource('first')
    second = scene.RegisterSource(f'#{first.get_value()}')
    names = NameTable(scene.model_inspector())
    with pytest.raises(UnknownNameError, match=r"is the name of a source .* of another, 'first'"):
        names.source(f'#{first.get_value()}')
    assert names.source('first') == first
    assert names.source(f'#{second.get_value()}') == second


def test_two_things_of_one_full_name_are_told_apart_by_their_sources():
    scene, _ = named_scene(('a', 'b::c'), ('a::b', 'c'), ('x', 'a::b::c'))
    names = NameTable(scene.model_inspector())
    with pytest.raises(UnknownNameError, match='3 frames share the name') as caught:
        names.frame('a::b::c')
    for told in ("'a::b::c' of source 'a' (#", "'a::b::c' of source 'a::b' (#", "'x::a::b::c' (#"):
        assert told in str(caught.value)
    with pytest.raises(UnknownNameError, match='3 geometries share') as caught:
        names.geometry('a::b::c/ball')
    assert "'a::b::c/ball' of source 'a::b' (#" in str(caught.value)
    names = NameTable(scene.model_inspector(), 'x::a::b::c')
    with pytest.raises(UnknownNameError, match=r"'x::a::b::c', the world \(#1\)"):
        names.frame('x::a::b::c')
