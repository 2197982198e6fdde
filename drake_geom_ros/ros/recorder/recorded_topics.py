"""The topics that a report and its audit need: see docs/recordings.md."""

from __future__ import annotations

_IN_NAMESPACE = ('joint_states', 'robot_description', 'robot_description_semantic')
_OF_NODE = (
    *('frame_poses', 'tracked_objects', 'scene', 'signed_distances', 'penetrations'),
    *('proximity_events', 'proximity_states'),
)


def topics_of(node: str, *, own_tf: bool = False, **named: str) -> list[str]:
    """Return the full names of the topics of a node.

    Args:
        node: Full name of the node, such as ``/cell/scene_graph``.
        own_tf: Whether ``/tf`` and ``/tf_static`` are those of the node's namespace.
        named: Names of ``joint_states``, ``robot_description`` and
            ``robot_description_semantic`` where they differ; relative to the namespace.
    """
    space = node.rpartition('/')[0]
    tf = space if own_tf else ''
    topics = ['/clock', f'{tf}/tf', f'{tf}/tf_static']
    for name in _IN_NAMESPACE:
        topic = named.get(name) or name
        topics.append(topic if topic.startswith('/') else f'{space}/{topic}')
    topics += [f'{node}/{topic}' for topic in _OF_NODE]
    return list(dict.fromkeys(topics))
