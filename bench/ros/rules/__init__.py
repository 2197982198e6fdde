"""A storm of proximity rules: a node, what happens to it, and a referee of its decisions."""
