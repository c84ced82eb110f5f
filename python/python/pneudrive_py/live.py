"""Following a poller cycle by cycle: in a loop, by a callback, or with asyncio.

The bus is polled by a thread of its own, which waits for nobody: who is too slow misses cycles and goes on with the newest.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from ._pneudrive import Poller
from .exceptions import PortError

__all__ = ["AsyncPoller", "Watcher", "rows"]

#: A cycle of the bus: what ``Poller.wait`` returns.
Row = dict[str, Any]

#: How long a thread waits for a cycle before it looks whether it is to end, s.
_LOOK_EVERY_S = 0.2


def rows(poller: Poller, *, timeout: float = 1.0) -> Iterator[Row]:
    """Cycles of the bus, from the next one on, until the poller ends.

    Parameters
    ----------
    poller : Poller
    timeout : float, default 1.0
        How long to wait for a cycle, s; then PneuDriveError is raised.

    Yields
    ------
    dict
        ``cycle``, ``t_s``, ``commands_kpa`` and ``pressures_kpa`` of shape (num_devices, 4): see ``Poller.wait``.
    """
    after: int | None = None
    while True:
        try:
            row = poller.wait(after, timeout=timeout)
        except PortError:
            # Whoever stopped it, or its trajectory, has ended it; a port that failed is said here.
            poller.join(0.0)
            return
        after = row["cycle"]
        yield row


class Watcher:
    """Calls a function with every cycle of the bus, on a thread of its own.

    Parameters
    ----------
    poller : Poller
    callback : callable
        Takes a dictionary as :func:`rows` yields. It may set the poller's set points. While it runs, cycles pass unseen. What it raises
        ends the calls, and is raised again by ``stop`` and at the end of the ``with`` block.

    Examples
    --------
    >>> with controller.poll(200) as poller, Watcher(poller, lambda row: print(row["t_s"])):
    ...     time.sleep(1.0)
    """

    def __init__(self, poller: Poller, callback: Callable[[Row], object]):
        self._poller = poller
        self._callback = callback
        self._stopping = threading.Event()
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="pneudrive-watcher", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        from .exceptions import PneuDriveError

        after: int | None = None
        while not self._stopping.is_set():
            try:
                row = self._poller.wait(after, timeout=_LOOK_EVERY_S)
            except PortError:
                return
            except PneuDriveError:
                # No cycle yet: a slow bus, or a port that is gone for a while.
                continue
            after = row["cycle"]
            try:
                self._callback(row)
            except BaseException as error:
                self._error = error
                return

    @property
    def running(self) -> bool:
        """Whether the function is still called."""
        return self._thread.is_alive()

    def stop(self) -> None:
        """Ends the calls, and raises what the callback raised. Further calls do nothing."""
        self._stopping.set()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        error, self._error = self._error, None
        if error is not None:
            raise error

    def __enter__(self) -> Watcher:
        return self

    def __exit__(self, exc_type: object, exc_value: object, traceback: object) -> None:
        try:
            self.stop()
        except BaseException:
            # What is on its way out of the block already says more.
            if exc_type is None:
                raise


class AsyncPoller:
    """A poller for asyncio.

    Reading and setting pressures never wait, so they are those of the poller: ``poller.set_pressure_commands(...)``,
    ``poller.get_all()``. What waits is awaited.

    Parameters
    ----------
    poller : Poller
        Such as ``controller.poll(200)``.

    Examples
    --------
    >>> async with AsyncPoller(controller.poll(200)) as poller:
    ...     poller.set_all(50.0)
    ...     async for row in poller:
    ...         print(row["pressures_kpa"])
    """

    def __init__(self, poller: Poller):
        self._poller = poller
        # One that is asked for cycles, and one that ends it meanwhile.
        self._threads = ThreadPoolExecutor(2, thread_name_prefix="pneudrive-async")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._poller, name)

    async def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._threads, function, *arguments)

    async def wait(self, after: int | None = None, *, timeout: float = 1.0) -> Row:
        """As ``Poller.wait``."""
        return await self._call(lambda: self._poller.wait(after, timeout=timeout))

    async def join(self, timeout: float | None = None) -> bool:
        """As ``Poller.join``."""
        return await self._call(self._poller.join, timeout)

    async def stop(self) -> None:
        """As ``Poller.stop``: boards are at 0 kPa when it returns."""
        await self._call(self._poller.stop)
        self._threads.shutdown(wait=False)

    async def __aiter__(self) -> AsyncIterator[Row]:
        after: int | None = None
        while True:
            try:
                row = await self.wait(after)
            except PortError:
                await self.join(0.0)
                return
            after = row["cycle"]
            yield row

    async def __aenter__(self) -> AsyncPoller:
        return self

    async def __aexit__(self, exc_type: object, exc_value: object, traceback: object) -> None:
        try:
            await asyncio.shield(self.stop())
        except Exception:
            if exc_type is None:
                raise
