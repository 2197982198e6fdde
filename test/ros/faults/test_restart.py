"""The node is killed and comes back with what was saved, transient filters not among it.

No number of the dead node means anything in the one that comes after it.
"""

import signal

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import LATCHED, Client, start_node
from ros.scene_calls import accepted, add_pair, exclude, poses, refused

pytestmark = pytest.mark.topics

PAIR = {'geometry_a': 's::a/ball', 'geometry_b': 's::b/ball'}
OTHER = {'geometry_a': 's::a/ball', 'geometry_b': 'other::a/ball'}


def reasons(client, pair):
    return list(accepted(client.call(srv.ExplainFilter, 'explain_filter', **pair)).reasons)


def test_a_saved_scene_comes_back_after_a_kill(tmp_path, lone_client):
    client, saved = lone_client, tmp_path / 'saved.yaml'
    node = start_node(tmp_path / 'log', anew=True, mesh_roots=f'["{tmp_path}"]')
    add_pair(client, 's')
    add_pair(client, 'other')
    accepted(client.call(srv.ApplyFilter, 'apply_filter', declaration=exclude(*PAIR.values())))
    lasting = exclude(*OTHER.values())
    accepted(client.call(srv.ApplyTransientFilter, 'apply_transient_filter', declaration=lasting))
    assert len(reasons(client, OTHER)) == 1
    text = accepted(client.call(srv.SaveScene, 'save_scene', path=str(saved))).text
    assert node.end(signal.SIGKILL) == -signal.SIGKILL
    again = start_node(tmp_path / 'again', anew=True, scene_file=saved)
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


def ids_of(scene):
    """Return the ids of sources, of frames but the world, and of geometries in a Scene."""
    frames = [frame.id for frame in scene.frames if frame.id != frame.parent_id]
    return [source.id for source in scene.sources], frames, [g.id for g in scene.geometries]


def test_no_number_comes_again_after_a_restart(tmp_path, lone_client):
    """Of two owners the one that was busy meanwhile reaches nothing of the other's."""
    busy = lone_client

    def filter_of(client, owner):
        fields = {'declaration': exclude(*PAIR.values()), 'owner': owner, 'lease': 60.0}
        answer = client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **fields)
        return accepted(answer).filter_id

    def life(client, log, owner):
        """Start a node, make the same scene in it, and return node, scene and a filter."""
        node = start_node(tmp_path / log)
        scenes = client.listen(msg.Scene, 'scene', LATCHED)
        add_pair(client, 's')
        client.wait_for(lambda: scenes and len(scenes[-1].geometries) == 2, 'the scene')
        return node, scenes[-1], filter_of(client, owner)

    node, before, old = life(busy, 'log', 'busy')
    assert node.end(signal.SIGKILL) == -signal.SIGKILL
    client = Client()
    node, after, new = life(client, 'again', 'other')
    try:
        assert old != new
        # As one that does not say who it is: even so the number alone reaches nothing.
        again = busy.call(srv.RenewFilter, 'renew_filter', filter_id=old, lease=60.0)
        assert not accepted(again).active
        gone = busy.call(srv.RemoveFilter, 'remove_filter', filter_id=old)
        assert not accepted(gone).removed
        assert reasons(client, PAIR) == [f"transient declaration {new} (owner 'other')"]
        short = {'filter_id': new, 'owner': 'other', 'lease': 0.1}
        assert accepted(client.call(srv.RenewFilter, 'renew_filter', **short)).active
        client.wait_for(lambda: not reasons(client, PAIR), 'the lease of the other to end')
        # What a client knows of the old scene says nothing of the new one.
        assert after.scene_version > before.scene_version + 1000
        for mine, others in zip(ids_of(before), ids_of(after), strict=True):
            assert mine
            assert others
            assert not {*mine} & {*others}
        for number in ids_of(before)[2]:
            pair = {'geometry_a': f'#{number}', 'geometry_b': PAIR['geometry_b']}
            refused(client.call(srv.ExplainFilter, 'explain_filter', **pair), f'#{number}')
    finally:
        client.close()
        assert node.end() == 0, node.output()
