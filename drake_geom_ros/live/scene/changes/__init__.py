"""Changes of the live scene, said once: each function returns a ``Change`` and makes nothing."""
