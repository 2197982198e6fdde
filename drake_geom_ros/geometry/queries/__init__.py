"""Questions about a posed scene, and their answers.

Enters: a model, filters, poses. Leaves: results over arrays, with records when indexed, gradients,
images. Imports ``model``, ``render``, and the rooms of ``_proximity`` that answer.
"""
