"""Drake's visualiser, spoken to by LCM.

Enters: a scene and its poses. Leaves: load and draw messages. Imports ``scene``, ``queries`` and
``model``, and lcm in ``drake_visualizer``.
"""
