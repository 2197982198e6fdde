"""What is drawn by VTK, an extra: imported only by a renderer that was asked for.

In: packed bodies, posed in the camera.
Out: images; nobody else imports VTK.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``, ``hydroelastic``,
    ``model``, ``sensors``,
    ``render``; numpy, vtkmodules.
"""
