"""Status report of a running node, for hosts without the ``ros2`` program: read only.

Prints, as text or JSON, the topics with their rates, the scene, frames without a pose, rejected
messages, and filters with their leases.
"""
