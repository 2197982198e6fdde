"""Signed distances in high precision and by search over directions, without any kernel."""
