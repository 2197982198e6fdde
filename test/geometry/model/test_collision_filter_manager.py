from types import SimpleNamespace

import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry.ids import FilterId, FrameId, GeometryId
from drake_geom_ros.geometry.model.collision_filter_declaration import CollisionFilterDeclaration
from drake_geom_ros.geometry.model.collision_filter_manager import FilterGroup, FilterStatement
from drake_geom_ros.geometry.model.geometry_set import GeometrySet
from drake_geom_ros.geometry.model.instances import GeometryFrame
from drake_geom_ros.geometry.model.properties import ProximityProperties, Role
from drake_geom_ros.geometry.model.scene_content import content_of
from drake_geom_ros.geometry.scene.scene_graph import SceneGraph

Declare = CollisionFilterDeclaration


def make_scene():
    """Return two links with two geometries each, one floor, and a link geometry without role."""
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('robot')
    world = scene_graph.world_frame_id()

    def register(frame, name, proximity=True):
        return scene_graph.RegisterGeometry(source, frame, instance(name, proximity=proximity))

    frames = [scene_graph.RegisterFrame(source, GeometryFrame(f'link{k}')) for k in range(2)]
    return SimpleNamespace(
        graph=scene_graph,
        source=source,
        register=register,
        frames=frames,
        a=[register(frames[0], f'a{k}') for k in range(2)],
        b=[register(frames[1], f'b{k}') for k in range(2)],
        floor=register(world, 'floor'),
        seen=register(frames[0], 'seen', proximity=False),
        manager=scene_graph.collision_filter_manager(),
    )


@pytest.fixture
def scene():
    return make_scene()


def candidates(scene):
    """Return C as the inspector has it."""
    return set(scene.graph.model_inspector().GetCollisionCandidates())


def test_apply_and_its_reverse(scene):
    before = candidates(scene)
    assert len(before) == 8
    scene.manager.Apply(Declare().ExcludeBetween(GeometrySet(scene.a), GeometrySet(scene.b)))
    assert candidates(scene) == {(g, scene.floor) for g in scene.a + scene.b}
    assert scene.manager.num_filtered_pairs() == 4
    scene.manager.Apply(Declare().AllowWithin(GeometrySet(scene.a + scene.b)))
    assert candidates(scene) == before
    assert scene.manager.num_filtered_pairs() == 0


def test_a_frame_means_the_proximity_geometries_it_has_now(scene):
    scene.manager.Apply(
        Declare().ExcludeBetween(GeometrySet(scene.frames[0]), GeometrySet(scene.floor))
    )
    later = scene.register(scene.frames[0], 'later')
    scene.graph.AssignRole(scene.source, scene.seen, ProximityProperties())
    explain = scene.manager.explain
    assert explain(scene.a[0], scene.floor) == ['persistent declaration 0']
    assert explain(later, scene.floor) == []
    assert explain(scene.seen, scene.floor) == []


def test_geometry_without_the_role_is_ignored_also_once_it_gets_it(scene):
    scene.manager.Apply(Declare().ExcludeWithin(GeometrySet([scene.seen, *scene.b])))
    assert scene.manager.num_filtered_pairs() == 0
    scene.graph.AssignRole(scene.source, scene.seen, ProximityProperties())
    assert scene.manager.num_filtered_pairs() == 0


def test_losing_the_role_loses_the_filters(scene):
    scene.manager.Apply(Declare().ExcludeBetween(GeometrySet(scene.a), GeometrySet(scene.floor)))
    scene.graph.RemoveRole(scene.source, scene.a[0], Role.kProximity)
    scene.graph.AssignRole(scene.source, scene.a[0], ProximityProperties())
    assert scene.manager.explain(scene.a[0], scene.floor) == []
    assert scene.manager.explain(scene.a[1], scene.floor) == ['persistent declaration 0']


@pytest.mark.parametrize('bad', [GeometryId(10**9), FrameId(10**9)])
@pytest.mark.parametrize('call', ['Apply', 'ApplyTransient', 'Activate', 'Deactivate'])
def test_an_invalid_id_changes_nothing(scene, call, bad):
    version = content_of(scene.graph).filters.version
    argument = GeometrySet([scene.a[0], bad])
    if call.startswith('Apply'):
        argument = Declare().ExcludeWithin(GeometrySet(scene.a + scene.b)).ExcludeWithin(argument)
    with pytest.raises(RuntimeError, match='1000000000'):
        getattr(scene.manager, call)(argument)
    assert content_of(scene.graph).filters.version == version
    assert len(candidates(scene)) == 8
    assert not scene.manager.has_transient_history()
    assert scene.manager.declarations() == []


@pytest.mark.parametrize('call', ['AddGroup', 'AddClique'])
def test_a_member_that_does_not_exist_is_an_error(scene, call):
    with pytest.raises(RuntimeError, match='1000000000'):
        getattr(scene.manager, call)('g', GeometrySet([*scene.a, *scene.b, GeometryId(10**9)]))
    assert scene.manager.filter_groups() == {}
    assert scene.manager.cliques() == {}


def test_several_cliques_come_together_or_not_at_all(scene):
    manager, pair = scene.manager, GeometrySet([scene.a[0], scene.b[0]])
    version = content_of(scene.graph).filters.version
    for name, members in (('second', GeometrySet([GeometryId(10**9)])), (' ', pair)):
        with pytest.raises(RuntimeError, match=r'1000000000|AddCliques.*empty'):
            manager.AddCliques([('first', pair), (name, members)])
        assert manager.cliques() == {}
        assert content_of(scene.graph).filters.version == version
    manager.AddCliques([('first', pair), (' second ', GeometrySet([*scene.a, scene.b[0]]))])
    together = candidates(scene)
    assert [*manager.cliques()] == ['first', 'second']
    other = scene.graph.Clone().collision_filter_manager()
    other.AddClique('first', pair)
    other.AddClique('second', GeometrySet([*scene.a, scene.b[0]]))
    assert other.cliques() == manager.cliques()
    assert 0 < len(together) < 8


def test_persistent_changes_are_refused_under_a_history(scene):
    exclude = Declare().ExcludeWithin(GeometrySet(scene.a + scene.b))
    filter_id = scene.manager.ApplyTransient(Declare().AllowWithin(GeometrySet(scene.a)))
    for refused in (
        lambda: scene.manager.Apply(exclude),
        lambda: scene.manager.AddGroup('g', GeometrySet(scene.a), ['g']),
        lambda: scene.manager.AddClique('c', GeometrySet(scene.a + scene.b)),
        lambda: scene.manager.AddCliques([('c', GeometrySet(scene.a + scene.b))]),
    ):
        with pytest.raises(RuntimeError, match=rf'\[{filter_id.get_value()}\] are active'):
            refused()
    assert len(candidates(scene)) == 8
    assert scene.manager.RemoveDeclaration(filter_id)
    scene.manager.Apply(exclude)
    assert len(candidates(scene)) == 4


def test_transient_declarations_come_and_go(scene):
    manager = scene.manager
    first = manager.ApplyTransient(Declare().ExcludeWithin(GeometrySet(scene.a + scene.b)))
    second = manager.ApplyTransient(
        Declare().AllowBetween(GeometrySet(scene.a[0]), GeometrySet(scene.b[0]))
    )
    assert manager.active_filter_ids() == [first, second]
    assert manager.IsActive(first)
    assert manager.explain(scene.a[1], scene.b[0]) == [
        f'transient declaration {first.get_value()}'
    ]
    assert manager.explain(scene.a[0], scene.b[0]) == []
    assert manager.RemoveDeclaration(first)
    assert not manager.IsActive(first)
    assert not manager.RemoveDeclaration(first)
    assert manager.has_transient_history()
    manager.Flatten()
    assert not manager.IsActive(second)
    assert not manager.RemoveDeclaration(second)
    assert not manager.IsActive(FilterId(0))
    assert len(candidates(scene)) == 8
    with pytest.raises(RuntimeError, match='filter_id'):
        manager.IsActive(1)


def test_transient_declarations_go_together(scene):
    manager = scene.manager
    everything = Declare().ExcludeWithin(GeometrySet(scene.a + scene.b))
    first, second, third = (manager.ApplyTransient(everything) for _ in range(3))
    assert manager.RemoveDeclarations([third, first, first, FilterId(0)]) == [third, first]
    assert manager.active_filter_ids() == [second]
    assert manager.RemoveDeclarations([first]) == []
    with pytest.raises(RuntimeError, match='filter_id'):
        manager.RemoveDeclarations([second, 1])
    assert manager.IsActive(second)


def test_a_context_has_filters_of_its_own(scene):
    context = scene.graph.CreateDefaultContext()
    of_context = scene.graph.collision_filter_manager(context)
    of_context.Apply(Declare().ExcludeWithin(GeometrySet(scene.a + scene.b)))
    assert scene.manager.num_filtered_pairs() == 0
    filter_id = scene.manager.ApplyTransient(Declare().ExcludeWithin(GeometrySet(scene.b)))
    assert not of_context.IsActive(filter_id)
    assert of_context.num_filtered_pairs() == 4


def test_deactivation_is_above_all_declarations(scene):
    scene.manager.ApplyTransient(Declare().AllowWithin(GeometrySet(scene.a + scene.b)))
    scene.manager.Deactivate(GeometrySet(scene.frames[0]))
    assert scene.manager.deactivated_geometries() == scene.a
    assert candidates(scene) == {(g, scene.floor) for g in scene.b}
    assert scene.manager.explain(scene.a[0], scene.b[0]) == ['deactivated']
    scene.manager.Activate(GeometrySet(scene.a[0]))
    assert scene.manager.deactivated_geometries() == scene.a[1:]
    assert scene.manager.explain(scene.a[0], scene.b[0]) == []


def test_groups_and_cliques_by_frames(scene):
    manager = scene.manager
    manager.AddGroup(' arms ', GeometrySet(frame_ids=scene.frames[:1]), ('legs', 'nobody'))
    manager.AddGroup('legs', GeometrySet(frame_ids=scene.frames[1:]))
    manager.AddClique('left', GeometrySet([scene.a[0], scene.floor]))
    assert manager.filter_groups() == {
        'arms': FilterGroup(scene.a, ['legs', 'nobody']),
        'legs': FilterGroup(scene.b, []),
    }
    assert manager.cliques() == {'left': [scene.a[0], scene.floor]}
    assert manager.group_masks(scene.a[0]) == (0b0011, 0b1100)
    assert manager.group_masks(scene.b[0]) == (0b0101, 0b0000)
    assert manager.group_masks(scene.floor) == (1, 0)
    assert manager.explain(scene.a[0], scene.b[1]) == ['group arms']
    assert manager.explain(scene.floor, scene.a[0]) == ['clique left']
    assert manager.num_filtered_pairs() == 5


@pytest.mark.parametrize('name', ['', '  ', 'universal', 3])
def test_bad_group_names(scene, name):
    with pytest.raises(RuntimeError, match='AddGroup'):
        scene.manager.AddGroup(name, GeometrySet(scene.a), ['universal'])
    assert scene.manager.filter_groups() == {}
    assert scene.manager.num_filtered_pairs() == 0


def test_ignored_groups_are_names_not_letters(scene):
    with pytest.raises(RuntimeError, match='must be names'):
        scene.manager.AddGroup('arms', GeometrySet(scene.a), 'legs')


def test_explain_refuses_what_has_no_filters(scene):
    with pytest.raises(RuntimeError, match='no proximity role'):
        scene.manager.explain(scene.a[0], scene.seen)
    with pytest.raises(RuntimeError, match='not a geometry of this scene'):
        scene.manager.explain(GeometryId(10**9), scene.a[0])


def test_what_was_declared_can_be_declared_again_elsewhere(scene):
    scene.manager.Apply(
        Declare()
        .ExcludeWithin(GeometrySet(scene.a + scene.b))
        .AllowBetween(GeometrySet(scene.a[0]), GeometrySet(scene.b))
    )
    said = scene.manager.declarations()
    assert said == [
        [
            FilterStatement('ExcludeWithin', scene.a + scene.b, []),
            FilterStatement('AllowBetween', [scene.a[0]], scene.b),
        ]
    ]


def test_other_types_are_refused(scene):
    with pytest.raises(RuntimeError, match='Apply: declaration'):
        scene.manager.Apply(GeometrySet(scene.a))
    with pytest.raises(RuntimeError, match='geometry_set'):
        scene.manager.Deactivate(scene.a)
