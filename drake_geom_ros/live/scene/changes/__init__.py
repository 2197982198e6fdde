"""Changes of the live scene: each function returns a ``Change`` and makes nothing."""
