"""How long what arrives by topic or by service holds the cycles of a node up."""
