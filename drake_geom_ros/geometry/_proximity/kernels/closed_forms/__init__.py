"""Pairs with a closed form, and points: spheres, boxes, capsules, half spaces."""
