"""Trajectories that run while the scene changes: their rest is judged again at each change."""
