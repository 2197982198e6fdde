"""Queries about a posed scene: ``QueryObject`` with results, gradients, images and surfaces.

Results are arrays, and records when they are indexed.
"""
