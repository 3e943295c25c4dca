"""Strategies of your own: what a callable sees, and what it answers.

>>> import pickline
>>> def nearest(snapshot):
...     return snapshot.processing_time.argmin()
>>> pattern = pickline.Pattern.grid(1.05, spacing=0.15, items=50)
>>> run = pickline.simulate("paper", pattern, nearest)
>>> run.picked == pickline.simulate("paper", pattern, "SPT,SPT").picked
True
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Snapshot", "Wait"]

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The line when a robot must decide: what it can pick now, and what is on the belt."""

    time: float
    """Time of the decision [s]."""
    robot: int
    """Index of the robot that decides, upstream first."""
    free_at: Numbers
    """When each robot is free [s], infinite if it waits forever or is down [robots]."""
    item: NDArray[np.int64]
    """The candidates, downstream first, as indices in the pattern [candidates]; never empty."""
    bin: NDArray[np.int64]
    """Index of the robot's bin that each goes into [candidates]."""
    x: Numbers
    """Where each is now along the travel, as reported [m], [candidates]."""
    y: Numbers
    """Where each is across the belt, as reported [m], [candidates]."""
    reward: Numbers
    """Its reward r [candidates]."""
    open: Numbers
    """First time at which the robot can leave for it [s], [candidates]."""
    close: Numbers
    """Last time at which the robot can leave for it [s], [candidates]."""
    processing_time: Numbers
    """Time from now until it is in its bin and the robot is free again [s], [candidates]."""
    distance_to_base: Numbers
    """Distance from where it is now to the robot's base [m], [candidates]."""
    view_item: NDArray[np.int64]
    """Unclaimed items on the belt that the camera has seen, downstream first [items in view]."""
    view_x: Numbers
    """Where each of them is now along the travel [m], [items in view]."""
    view_y: Numbers
    """Where each of them is across the belt [m], [items in view]."""
    view_reward: Numbers
    """Its reward r [items in view]."""


@dataclass(frozen=True)
class Wait:
    """The answer to pick nothing now."""

    until: float | None = None
    """When the robot decides again [s], later than now; None for when it can reach another item."""

    def __post_init__(self) -> None:
        if self.until is None:
            return
        try:
            if isinstance(self.until, str | bool):
                raise TypeError
            until = float(self.until)
        except (TypeError, ValueError):
            raise TypeError(
                f"until: {self.until!r} is not a time\n"
                "  cure: give seconds, later than snapshot.time, or None"
            ) from None
        object.__setattr__(self, "until", until)
