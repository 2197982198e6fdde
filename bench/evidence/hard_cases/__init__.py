"""The hard cases: what they are, who answers them rightly, and how that is told."""
