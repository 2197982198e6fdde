"""Queries about poses that carry derivatives: the instantiations for AutoDiffXd.

In: poses whose numbers carry derivatives.
Out: answers whose numbers do.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``model``, ``sensors``,
    ``render``, ``queries``, ``autodiffutils``, ``scene``, ``_proximity``; numpy.
"""
