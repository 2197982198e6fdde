"""Names in few words, that nobody mistakes for one another."""

from viewing.scenes import local_scene

from drake_geom_ros.viewing.short_names import short_names


def test_what_all_share_is_left_out():
    names = {
        'left::panda_link5/collision_0': 'left::link5/0',
        'left::panda_link5/collision_1': 'left::link5/1',
        'left::panda_hand/collision_0': 'left::hand',
        'objects::can/can': 'objects::can',
        'objects::bottle/body': 'objects::bottle/body',
        'objects::bottle/neck': 'objects::bottle/neck',
        'scenery::world/left_pedestal': 'scenery::left_pedestal',
        'scenery::world/lamp': 'scenery::lamp',
    }
    assert short_names(names) == names


def test_of_one_name_its_end_is_left():
    assert short_names([]) == {}
    assert short_names(['s::a/ball']) == {'s::a/ball': 'ball'}


def test_words_are_left_whole_and_whatever_name_stays_itself():
    names = ['s::a/geometry 12', 's::a/geometry 1', 's::a/geometry 13']
    assert list(short_names(names).values()) == ['12', '1', '13']
    hostile = ['s::a/', 's::a/b', 's::a_/b', 's::a/b/c', 's::a::b/c', 's::_/_', 's::_/__', 't::/']
    assert len(set(short_names(hostile).values())) == len(hostile)


def test_the_bodies_of_the_demo_are_told_apart():
    scene = local_scene('scenes/two_pandas.yaml')
    cast = scene.moment(0.0, 'bound').geometries
    assert len(cast.names) == len(set(cast.short_names.values())) == 102
    assert max(map(len, cast.short_names.values())) == len('scenery::right_pedestal')
    assert 'right::rightfinger/2' in cast.short_names.values()
