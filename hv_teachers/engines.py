"""Independent jobs in many processes, here or on many machines: every job is done, whoever is killed on the way.

A job must give the same result however often it is done. `pool` is processes of this machine; `ray` is a Ray cluster
(`RAY_ADDRESS`, or one that is started here), whose machines share the file system.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

ENGINES = ("pool", "ray")
MAX_DEATHS = 20
"""Deaths in a row, without a job done between them, after which a job is taken to be deadly."""


@dataclass(frozen=True)
class Slice:
    """Every `of`-th of many jobs, beginning with number `index`: the share of one machine.

    Raises:
        ValueError: there is no such share.
    """

    index: int
    of: int

    def __post_init__(self) -> None:
        if not 0 <= self.index < self.of:
            valid = f"0/{self.of} to {self.of - 1}/{self.of}"
            raise ValueError(f"shard: {self.index}/{self.of} is not valid; valid: {valid}")

    @staticmethod
    def parse(text: str) -> Slice:
        """`I/N`, I from 0 to N - 1.

        Raises:
            ValueError: it is something else.
        """
        index, sign, of = text.partition("/")
        if not (sign and index.isdecimal() and of.isdecimal() and int(of) > 0):
            raise ValueError(f"shard: {text!r} is not valid; valid: I/N, such as 0/16")
        return Slice(int(index), int(of))

    def __contains__(self, number: int) -> bool:
        return number % self.of == self.index


def check_engine(engine: str) -> None:
    """Raises ValueError unless there is such an engine, and it is installed."""
    if engine not in ENGINES:
        raise ValueError(f"engine: {engine!r} is not valid; valid: {', '.join(ENGINES)}")
    if engine == "ray":
        try:
            import ray  # noqa: F401
        except ImportError as error:
            raise ValueError(
                f"engine: 'ray' is not installed here ({error}); install it with: pip install 'lerobot_policy_hv[ray]'"
            ) from None


def num_processes(workers: int) -> int:
    """As many as wanted, one per core for 0."""
    return workers or os.cpu_count() or 1


def run_jobs(
    function: Callable[[Any], Any],
    jobs: Sequence[Any],
    *,
    workers: int = 0,
    engine: str = "pool",
    prepare: Callable[..., None] | None = None,
    arguments: tuple[Any, ...] = (),
) -> Iterator[Any]:
    """Results of `function(job)`, as they come.

    Args:
        function: of a module; so is `prepare`.
        jobs: what can be pickled.
        workers: processes, 0 for one per core (of a cluster: as many as it has); a pool of 1 is this process itself.
        engine: one of `ENGINES`.
        prepare: is called once in every process, before its first job.
        arguments: of `prepare`.

    Raises:
        ValueError: there is no such engine here.
        RuntimeError: processes die whenever they try what is left.
    """
    check_engine(engine)
    if not jobs:
        return
    number = min(num_processes(workers), len(jobs))
    if engine == "ray":
        yield from _by_ray(function, jobs, workers, prepare, arguments)
    elif number > 1:
        yield from _by_pool(function, jobs, number, prepare, arguments)
    else:
        if prepare is not None:
            prepare(*arguments)
        yield from map(function, jobs)


def _by_pool(
    function: Callable, jobs: Sequence[Any], workers: int, prepare: Callable | None, arguments: tuple
) -> Iterator[Any]:
    left = dict(enumerate(jobs))
    deaths = 0
    while left:
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(min(workers, len(left)), mp_context=multiprocessing.get_context("spawn"))
        try:
            futures = {pool.submit(_do, function, job, prepare, arguments): i for i, job in left.items()}
            for future in as_completed(futures):
                result = future.result()
                del left[futures[future]]
                deaths = 0
                yield result
        except BrokenProcessPool:
            # a process was killed, and took the others' jobs in flight with it: what is left is done anew
            deaths += 1
            if deaths > MAX_DEATHS:
                raise RuntimeError(f"{len(left)} jobs are left, and processes die whenever they try them") from None
        except BaseException:
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _by_ray(
    function: Callable, jobs: Sequence[Any], workers: int, prepare: Callable | None, arguments: tuple
) -> Iterator[Any]:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    import ray

    begun_here = not ray.is_initialized()
    if begun_here:
        local: dict[str, Any] = {} if os.environ.get("RAY_ADDRESS") else {"include_dashboard": False}
        if local and workers:
            local["num_cpus"] = workers
        ray.init(log_to_driver=False, logging_level="ERROR", **local)
    try:
        # retry_exceptions stays off: an error of ours is an error; a process or machine that is gone is not
        task = ray.remote(num_cpus=1, max_retries=MAX_DEATHS)(_do)
        waiting = [task.remote(function, job, prepare, arguments) for job in jobs]
        while waiting:
            done, waiting = ray.wait(waiting, num_returns=1)
            yield from (_got(ray, reference) for reference in done)
    finally:
        if begun_here:
            ray.shutdown()


def _got(ray: Any, reference: Any) -> Any:
    try:
        return ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        raise (error.cause if isinstance(error.cause, Exception) else error) from None


_PREPARED: tuple[Any, ...] | None = None


def _do(function: Callable, job: Any, prepare: Callable | None, arguments: tuple) -> Any:
    global _PREPARED
    if prepare is not None and _PREPARED != (prepare.__qualname__, *arguments):
        prepare(*arguments)
        _PREPARED = (prepare.__qualname__, *arguments)
    return function(job)
