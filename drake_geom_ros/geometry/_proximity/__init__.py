"""Arrays in, arrays out: the arithmetic behind the queries (private)."""
