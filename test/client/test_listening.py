"""Which result is handed on with which scene: no ROS is spun here."""

from types import SimpleNamespace as Some

from ros.demo import scenes

from drake_geom_ros.client.listening import _Arrivals


def test_a_result_waits_for_its_scene_and_one_of_before_is_dropped():
    taken = []
    arrivals = _Arrivals(lambda message, table: taken.append((message.name, table.version)))
    arrivals.hear(Some(scene_version=2, name='first'), None)
    arrivals.hear(Some(scene_version=2, name='second'), None)
    assert taken == []
    arrivals.look(scenes.table(version=1))
    assert taken == []
    arrivals.look(scenes.table(version=2))
    assert taken == [('second', 2)]
    arrivals.hear(Some(scene_version=2, name='third'), scenes.table(version=2))
    arrivals.hear(Some(scene_version=2, name='late'), scenes.table(version=3))
    arrivals.look(scenes.table(version=3))
    assert taken == [('second', 2), ('third', 2)]
