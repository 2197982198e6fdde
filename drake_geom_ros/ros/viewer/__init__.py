"""Browser page of a running node: reads its topics and calls its services."""
