"""Queries about poses that carry derivatives: the instantiations for AutoDiffXd."""
