"""SceneGraph: where sources register what there is, and where queries start.

Enters: registrations and contexts. Leaves: ports that take poses and give query objects, and
compiled kernels before anybody waits for them. Imports ``model``, ``queries`` and ``render``.
"""
