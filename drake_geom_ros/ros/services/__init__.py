"""What answers calls: a handler each, and the table of all."""
