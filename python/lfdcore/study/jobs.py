"""Jobs of a study over processes, in the jobs' order whatever the number of processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Protocol, TypeVar

from lfdcore.progress import Progress, silent

Result_co = TypeVar("Result_co", covariant=True)


ENDING = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
"""Signals that end a program"""

LEAVES_THE_PIPE_OPEN = sys.version_info < (3, 11, 5)
"""A pool whose workers are ended goes on writing a job into a pipe that nobody reads, for ever (Python's issue 94777).
Later versions close it in a thread of theirs: to close it here as well would close a descriptor twice."""


class Runnable(Protocol[Result_co]):
    """What can be sent to a process and be run there."""

    def run(self) -> Result_co:
        """-> what comes back"""


def run_jobs(
    jobs: Sequence[Runnable[Result_co]],
    progress: Progress | None = None,
    processes: int | None = None,
) -> tuple[Result_co, ...]:
    """Runs jobs over processes -> their results (a Job's trace) in the jobs' order, whatever the number of processes.

    progress(done, total) is called after each. An error or Ctrl-C ends all processes at once, within their jobs.
    """
    count, tell = min(processes or os.cpu_count() or 1, max(1, len(jobs))), progress or silent
    if count == 1:
        results: list[Result_co] = []
        for job in jobs:
            results.append(job.run())
            tell(len(results), len(jobs))
        return tuple(results)
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(count, initializer=_leave_the_end_to_the_parent) as pool:
        try:
            with _end_deferred():
                futures = [pool.submit(job.run) for job in jobs]
            for done, future in enumerate(as_completed(futures), 1):
                future.result()
                tell(done, len(jobs))
        except BaseException:
            _end(pool, set(multiprocessing.active_children()) - others)
            raise
    return tuple(future.result() for future in futures)


def _leave_the_end_to_the_parent() -> None:
    """In a worker: a terminal sends Ctrl-C to all, but the parent ends its workers, by SIGTERM."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)


def _end(pool: ProcessPoolExecutor, workers: set[BaseProcess]) -> None:
    for process in workers:
        process.terminate()
    queue = getattr(pool, "_call_queue", None)
    if queue is not None and LEAVES_THE_PIPE_OPEN:
        queue._reader.close()
    pool.shutdown(cancel_futures=True)


@contextmanager
def _end_deferred() -> Iterator[None]:
    """A signal to end meanwhile counts afterwards: between a process's birth and its entry in a list nobody could end
    it, and a worker is born with its parent's handlers."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
