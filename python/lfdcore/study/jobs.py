"""Jobs of a study over processes, in the jobs' order whatever the number of processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Protocol, TypeVar

from lfdcore.progress import Progress

Result_co = TypeVar("Result_co", covariant=True)


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
    count, tell = min(processes or os.cpu_count() or 1, max(1, len(jobs))), progress or (lambda done, total: None)
    if count == 1:
        results: list[Result_co] = []
        for job in jobs:
            results.append(job.run())
            tell(len(results), len(jobs))
        return tuple(results)
    others = set(multiprocessing.active_children())
    deaf = (signal.SIGINT, signal.SIG_IGN)  # a terminal sends Ctrl-C to all: this process ends the others
    with ProcessPoolExecutor(count, initializer=signal.signal, initargs=deaf) as pool:
        try:
            with _interrupt_deferred():
                futures = [pool.submit(job.run) for job in jobs]
            for done, future in enumerate(as_completed(futures), 1):
                future.result()
                tell(done, len(jobs))
        except BaseException:
            _end(pool, set(multiprocessing.active_children()) - others)
            raise
    return tuple(future.result() for future in futures)


def _end(pool: ProcessPoolExecutor, workers: set[BaseProcess]) -> None:
    for process in workers:
        process.terminate()
    queue = getattr(pool, "_call_queue", None)
    if queue is not None:
        # Python before 3.11.5 goes on writing a job into a pipe that nobody reads, for ever (its issue 94777)
        queue._reader.close()
    pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupt_deferred() -> Iterator[None]:
    """Ctrl-C meanwhile counts afterwards: between a process's birth and its entry in a list nobody could end it."""
    if threading.current_thread() is not threading.main_thread():  # which alone is interrupted
        yield
        return
    pending: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: pending.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pending:
        raise KeyboardInterrupt
