"""Questions about a posed scene, and their answers.

In: a model, filters, poses.
Out: results over arrays, records when indexed, gradients, images, contact surfaces.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``model``, ``sensors``, ``render``, ``_proximity``, ``_contact_surfaces``; numpy.
"""
