"""SceneGraph: where sources register what there is, and where queries start.

In: registrations and contexts.
Out: ports that take poses and give query objects; kernels compiled before anybody waits.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``model``, ``sensors``,
    ``render``, ``queries``, ``autodiffutils``, ``_proximity``; numpy.
"""
