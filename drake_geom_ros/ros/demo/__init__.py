"""The demo: a node, a player and a client, and what a person sees of them."""
