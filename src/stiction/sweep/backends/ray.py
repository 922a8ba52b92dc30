"""The backend on Ray: a local one by default, a cluster with an address.

A batch is a Ray task of one core. Ray's own retries are off: a batch whose worker died is looked up in the journals
first, so that no finished run is done again. Nodes that see the sweep's folder under the same path write their rows
there themselves; from others they come back with the answer, and those of a batch under way are lost with its worker.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

from stiction.bench.worker import THREADS
from stiction.sweep.backends import Report, Take, Work
from stiction.sweep.backends.local import cores
from stiction.sweep.points import Point
from stiction.sweep.runner import Answer, run_batch


class RayBackend:
    """Ray tasks.

    Args:
        workers: how many batches at a time; one for each core of the cluster if left out.
        address: of a cluster, such as ``auto`` or ``ray://head:10001``; a Ray on this machine if left out.
    """

    name = "ray"

    def __init__(self, workers: int | None = None, address: str | None = None) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # a sweep tells nobody about itself
        import ray

        self._ray = ray
        self._owned = not ray.is_initialized()
        if self._owned:
            settings: dict[str, Any] = {
                "logging_level": "error",
                "log_to_driver": False,
                "runtime_env": {"env_vars": dict.fromkeys(THREADS, "1")},
            }
            if address is None:
                # "local" starts one although RAY_ADDRESS may name a cluster, which nobody asked for
                ray.init("local", num_cpus=workers or cores(), include_dashboard=False, **settings)
            else:
                ray.init(address, **settings)
        self.workers = workers or max(1, int(ray.cluster_resources().get("CPU", 1)))

    def run(self, work: Work, take: Take) -> Iterator[Report]:
        """See :class:`stiction.sweep.backends.Backend`."""
        ray = self._ray
        task = ray.remote(run_batch).options(num_cpus=1, max_retries=0)
        job = ray.put(work.job)
        busy: dict[Any, list[Point]] = {}
        try:
            while True:
                while len(busy) < self.workers and (batch := take()):
                    busy[task.remote(job, batch, work.folder, work.session)] = batch
                if not busy:
                    return
                # with a limit, so that Ctrl-C is heard
                ready, _ = ray.wait(list(busy), num_returns=1, timeout=1.0)
                for reference in ready:
                    yield self._report(reference, busy.pop(reference))
        finally:
            # workers stop after the run that they are at, because the session has ended
            if busy:
                ray.wait(list(busy), num_returns=len(busy), timeout=20.0)
            if self._owned:
                ray.shutdown()

    def _report(self, reference: Any, batch: list[Point]) -> Report:
        try:
            return Report(batch, Answer(*self._ray.get(reference)))
        except self._ray.exceptions.RayError as error:
            lines = str(error).strip().splitlines() or [type(error).__name__]
            return Report(batch, None, f"{type(error).__name__}: {lines[0]}")
