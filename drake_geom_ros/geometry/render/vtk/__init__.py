"""What is drawn by VTK, an extra: imported only by a renderer that was asked for.

Enters: packed bodies, posed in the camera. Leaves: images. Nobody else imports VTK.
"""
