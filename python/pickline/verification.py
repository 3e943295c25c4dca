"""Picks of any origin, checked against the model."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickline import _pickline
from pickline._arguments import checked
from pickline._pickline import Pattern, Station
from pickline.columns import Columns, Numbers, Texts
from pickline.result import Result, call_text
from pickline.simulation import as_station

__all__ = ["Verification", "Violations", "check"]


@dataclass(frozen=True, eq=False)
class Violations(Columns):
    """Everything that contradicts the model, in the order of the file."""

    line: NDArray[np.int64]
    """Line of the file."""
    robot: Texts
    """Name of the robot, or what the file has in its place."""
    item: Texts
    """Name of the item, or what the file has in its place."""
    decide_s: Numbers
    """When the robot left for it [s]; NaN if the line names what does not exist."""
    grasp_s: Numbers
    """Start of the grasp [s]."""
    x_m: Numbers
    """Where the item was to be met along the travel [m]."""
    y_m: Numbers
    """Where the item was to be met across the belt [m]."""
    kind: Texts
    """What it is about, in snake case."""
    problem: Texts
    """What is wrong, and what would be right."""
    accepted_from_s: Numbers
    """The least tolerance with which it would be accepted [s]; NaN if none helps."""


@dataclass(frozen=True, eq=False, repr=False)
class Verification(Result):
    """What the independent checker says about picks."""

    confirmed: bool
    """Whether nothing contradicts the model."""
    items: int
    """Number of items in the pattern."""
    picks: int
    """Number of picks in the file."""
    failures: int
    """Number of failed attempts in the file."""
    violations: Violations
    """What contradicts the model."""
    ignored_columns: list[str]
    """Columns of the file that were ignored."""

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        same = ("confirmed", "items", "picks", "failures", "ignored_columns")
        violations = Violations._read(tables["violations"])
        return {name: document[name] for name in same} | dict(violations=violations)

    def __bool__(self) -> bool:
        return self.confirmed

    def __repr__(self) -> str:
        verdict = "confirmed" if self.confirmed else f"{len(self.violations)} violations"
        return f"<Verification of {self.picks} picks: {verdict}>"


@checked()
def check(
    picks: str | os.PathLike[str],
    station: Station | str | os.PathLike[str],
    pattern: Pattern,
    *,
    tolerance: float = 0.0,
    camera_x: float | None = None,
    update_hz: float = 0.0,
) -> Verification:
    """Check the picks of any run from a file, as ``pickline check`` does.

    The result is true if nothing contradicts the model. It does not raise an exception if something
    does: that is a result.

    Args:
        picks: The file (CSV): ``robot``, ``item``, ``decide_s``, ``grasp_s``, ``release_s`` and more
            (``pickline help check``).
        station: A station, the name of a built-in one, or a station file.
        pattern: The items that were picked from.
        tolerance: How far each time may be off [s], for rounded or measured times.
        camera_x: Position of the camera [m]; no robot may leave for an item that has not passed it.
        update_hz: Robots may leave only at multiples of 1 / this [Hz]; 0 for any time.

    Raises:
        ValueError: A value, or a line that cannot be read.
        OSError: A file that cannot be read.
    """
    call = call_text(check, locals())
    report = _pickline.check(
        as_station(station),
        pattern,
        picks,
        tolerance=tolerance,
        camera_x=camera_x,
        update_hz=update_hz,
        call=call,
    )
    return Verification._of(report)
