"""The node is killed and comes back with what was saved, transient filters not among it."""

import signal

from drake_geom_msgs import srv
from ros.harness import Client, start_node
from ros.scene_calls import accepted, add_pair, exclude, poses

PAIR = {'geometry_a': 's::a/ball', 'geometry_b': 's::b/ball'}
OTHER = {'geometry_a': 's::a/ball', 'geometry_b': 'other::a/ball'}


def reasons(client, pair):
    return list(accepted(client.call(srv.ExplainFilter, 'explain_filter', **pair)).reasons)


def test_a_saved_scene_comes_back_after_a_kill(tmp_path, lone_client):
    client, saved = lone_client, tmp_path / 'saved.yaml'
    node = start_node(tmp_path / 'log', mesh_roots=f'["{tmp_path}"]')
    add_pair(client, 's')
    add_pair(client, 'other')
    accepted(client.call(srv.ApplyFilter, 'apply_filter', declaration=exclude(*PAIR.values())))
    lasting = exclude(*OTHER.values())
    accepted(client.call(srv.ApplyTransientFilter, 'apply_transient_filter', declaration=lasting))
    assert len(reasons(client, OTHER)) == 1
    text = accepted(client.call(srv.SaveScene, 'save_scene', path=str(saved))).text
    assert node.end(signal.SIGKILL) == -signal.SIGKILL
    again = start_node(tmp_path / 'again', scene_file=saved)
    client = Client()  # one that has never heard of the dead node
    try:
        assert reasons(client, PAIR) == ['persistent declaration 0']
        assert reasons(client, OTHER) == []
        state = accepted(client.call(srv.GetFilters, 'get_filters'))
        assert not state.has_transient_history
        assert accepted(client.call(srv.SaveScene, 'save_scene')).text == text
        moved = poses(['s::a'], [(1, 0, 0)])
        accepted(client.call(srv.HasCollisions, 'has_collisions', poses=moved))
    finally:
        client.close()
        assert again.end() == 0, again.output()
