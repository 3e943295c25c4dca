"""The progress of long calls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

# No progress, a bar by tqdm, or a callable of the steps done, the steps in total and what is being done.
Progress = bool | Callable[[int, int, str], object]

Watch = Callable[[int, int, str], object] | None


@contextmanager
def watcher(progress: Progress) -> Iterator[Watch]:
    """What is called with the progress, if anything is."""
    if progress is False:
        yield None
    elif progress is True:
        bars = _Bars()
        try:
            yield bars
        finally:
            bars.close()
    elif callable(progress):
        yield progress
    else:
        raise TypeError(
            f"progress: {progress!r} is neither a bool nor a callable\n"
            "  cure: give True for a bar, or a callable of (done, total, what)"
        )


class _Bars:
    """One bar by tqdm for each stage of the work."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            raise ImportError(
                "progress: True needs tqdm, which is not installed\n"
                "  cure: pip install tqdm, or give a callable of (done, total, what)"
            ) from None
        self._tqdm = tqdm
        self._bar: Any = None
        self._what = ""

    def __call__(self, done: int, total: int, what: str) -> None:
        if self._bar is None or what != self._what or done < self._bar.n:
            self.close()
            self._bar = self._tqdm(total=total, desc=what)
            self._what = what
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """End the bar."""
        if self._bar is not None:
            self._bar.close()
