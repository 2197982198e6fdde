"""Drake's visualiser, spoken to by LCM.

In: a scene and its poses.
Out: load and draw messages.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``model``, ``sensors``,
    ``render``, ``queries``, ``autodiffutils``, ``scene``; numpy.
"""
