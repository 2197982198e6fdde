"""The catalogue of hard cases, and the judge that is the same for us and for peers."""
