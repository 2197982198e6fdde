"""The page in the browser, drawn with viser: ``serve`` shows a scene until it is interrupted.

In: a scene to show, and clicks.
Out: a page in the browser.
May import: ``math``, ``common``, ``geometry``, ``trajectories``, ``viewing``; numpy, viser,
    imageio, websockets, trimesh, PIL.
"""
