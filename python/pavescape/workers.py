"""Processes that compute Python functions for the threads of a search."""
from __future__ import annotations

import functools
import multiprocessing.connection
import pickle
import queue
import signal
import threading
import weakref
from collections.abc import Callable, Sequence
from typing import Any

from . import _pavescape

_spawn = multiprocessing.get_context("spawn")  # a fork would copy the locks of threads that it does not have
_patience_s = 2.0


def _serve(connection: Any, pickled: bytes) -> None:
    """The life of a process: numbers in, an answer out, until the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C lets what is running end
    try:
        try:
            functions = pickle.loads(pickled)
        except Exception as error:
            connection.send(f"{type(error).__name__}: {error}")
            return
        connection.send("")
        while True:
            which, x = connection.recv()
            connection.send(functions[which](x))
    except (EOFError, OSError):
        return


class _Worker:
    """One such process, and the connection to it."""

    def __init__(self, pickled: bytes) -> None:
        self.connection, theirs = _spawn.Pipe()
        self.process = _spawn.Process(target=_serve, args=(theirs, pickled), daemon=True)
        self.process.start()
        theirs.close()

    def end(self) -> int | None:
        """Its exit status, negative: the number of a signal. It is killed where it does not end by itself."""
        self.connection.close()
        self.process.join(_patience_s)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join(_patience_s)
        return self.process.exitcode


def _end_all(workers: set[_Worker]) -> None:
    for worker in list(workers):
        worker.connection.close()
    for worker in list(workers):
        worker.end()


class Workers:
    """Functions computed by processes of their own, as many calls at once as there are processes; others wait for one.

    functions: each takes an array and gives an array, or a reason as text; they are pickled. A process is started when a call finds none idle. All end
    with this object, or with the interpreter. Raises ValueError where a function cannot be pickled.
    """

    def __init__(self, functions: Sequence[Callable[[Any], Any]], processes: int) -> None:
        try:
            self._pickled = pickle.dumps(tuple(functions))
        except Exception as error:
            raise ValueError(f"processes = {processes}: the function cannot be handed to another process ({error}); allowed: processes = 0, or a "
                             "function with a name at the top of a file") from None
        self._idle: queue.LifoQueue[_Worker | None] = queue.LifoQueue()  # None: not started yet
        for _ in range(processes):
            self._idle.put(None)
        self._alive: set[_Worker] = set()
        self._lock = threading.Lock()
        self._why_not = ""
        weakref.finalize(self, _end_all, self._alive)

    def function(self, which: int) -> Callable[[Any], Any]:
        """The which-th of the functions, to be called from any thread."""
        return functools.partial(self._call, which)

    def _call(self, which: int, x: Any) -> Any:
        worker = self._idle.get()
        try:
            if worker is None:
                worker = self._started()
            if worker is None:
                return f"{self._why_not} ({_pavescape.passing_words})"
            worker.connection.send((which, x))
            return worker.connection.recv()
        except (EOFError, OSError):
            status = self._ended(worker)
            worker = None
            return "the process of the function ended with " + (f"signal {-status}" if status is not None and status < 0 else f"status {status}")
        except BaseException:  # its answer is still to come: to nobody
            self._ended(worker)
            worker = None
            raise
        finally:
            self._idle.put(worker)

    def _started(self) -> _Worker | None:
        """Nothing: none can be started, now or ever, and why."""
        if self._why_not:
            return None
        words = 'it ended at its start; does the script call from under if __name__ == "__main__"?'
        worker = None
        try:
            worker = _Worker(self._pickled)
            with self._lock:
                self._alive.add(worker)
            words = worker.connection.recv()
            if not words:
                return worker
        except (EOFError, OSError):
            pass
        except Exception as error:
            words = f"{type(error).__name__}: {' '.join(str(error).split())}"
        self._ended(worker)
        self._why_not = f"no process for the function: {words}"
        return None

    def _ended(self, worker: _Worker | None) -> int | None:
        if worker is None:
            return None
        with self._lock:
            self._alive.discard(worker)
        return worker.end()
