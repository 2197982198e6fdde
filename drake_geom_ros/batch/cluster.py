"""Executor of a Dask cluster; only this file imports Dask."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from drake_geom_ros.batch.running import BatchError


@contextmanager
def cluster_executor(address: str, timeout: float = 10.0) -> Iterator[Executor]:
    """Yield an executor of the Dask scheduler at an address, such as ``tcp://host:8786``.

    Its workers need this package in the same version. They send answers directly, or by way of the
    scheduler if they cannot be reached. Raises BatchError if Dask is not installed, or there is no
    answer from the address within ``timeout`` [s].
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise BatchError(
            f"a cluster takes Dask's distributed, which cannot be imported ({error}): "
            "pip install distributed, or this package with its extra 'cluster'"
        ) from None
    try:
        client = Client(address, timeout=timeout, set_as_default=False, direct_to_workers=True)
    except (OSError, ValueError) as error:
        raise BatchError(f'no scheduler at {address}: {error}') from None
    with client:
        yield client.get_executor(pure=False)  # a lost block is submitted again
