"""How far a rendering is, as a share that never falls."""

from __future__ import annotations

from collections.abc import Callable


class Meter:
    """Turns finished work into a share of all, though later passes are not known beforehand.

    Parameters
    ----------
    tell : callable, optional
        Called with each new share, 0 to 1.
    """

    def __init__(self, tell: Callable[[float], None] | None) -> None:
        self._tell = tell
        self.share = 0.0
        self._base = 0.0
        self._pass_share = 0.0
        self._expected = self._done = 0

    def expect(self, tiles: int) -> None:
        """Begin a stretch of so many tiles; it gets half of what is left."""
        self._base = self.share
        self._pass_share = 0.5 * (1.0 - self._base)
        self._expected, self._done = tiles, 0

    def advance(self, tiles: int) -> None:
        """Count so many more tiles of the stretch."""
        self._done += tiles
        done = min(1.0, self._done / max(self._expected, 1))
        self.share = max(self.share, self._base + self._pass_share * done)
        if self._tell is not None:
            self._tell(self.share)

    def finish(self) -> None:
        """Tell that all is done."""
        self.share = 1.0
        if self._tell is not None:
            self._tell(1.0)
