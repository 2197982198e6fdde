"""The page in the browser for a running node: learns all from topics, asks by services."""
