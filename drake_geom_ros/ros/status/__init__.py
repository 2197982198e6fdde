"""What a running node has and does, for who has no ``ros2`` program: read and told, nothing set.

In: the name of a node.
Out: topics with rates, the scene, who waits, what was refused, filters with their leases; as text
    or as JSON.
May import: ``common``, ``client``, ``sensing``, ``ros``; ROS.
"""
