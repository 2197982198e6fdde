"""Queries about poses with derivatives: the instantiations for ``AutoDiffXd``.

``SceneGraph_[AutoDiffXd]`` and its kin take poses whose numbers have gradients. Their results have
gradients, too.
"""
