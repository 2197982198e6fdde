"""The topics of a node by its full name."""

from drake_geom_ros.ros.recorder.recorded_topics import topics_of


def test_names_are_those_of_the_namespace_but_for_the_clock_and_tf():
    topics = topics_of('/cell/geometry')
    assert topics[:3] == ['/clock', '/tf', '/tf_static']
    assert {'/cell/joint_states', '/cell/geometry/scene', '/cell/robot_description'} < set(topics)
    assert all(topic.startswith('/cell/') for topic in topics[3:])


def test_tf_may_be_that_of_the_namespace_and_topics_may_have_other_names():
    topics = topics_of('/cell/geometry', own_tf=True, joint_states='arm/states')
    assert topics[1:4] == ['/cell/tf', '/cell/tf_static', '/cell/arm/states']
    assert '/states' in topics_of('/scene_graph', joint_states='/states')
    assert '/joint_states' in topics_of('/scene_graph')


def test_a_topic_is_named_once():
    topics = topics_of('/scene_graph', robot_description='d', robot_description_semantic='d')
    assert topics.count('/d') == 1
