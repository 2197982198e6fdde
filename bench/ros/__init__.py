"""The node under load: delay against a bare round trip, and a soak of everything at once."""
