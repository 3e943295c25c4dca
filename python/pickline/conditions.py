"""The conditions of runs: what is known, and what may go wrong."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypedDict

__all__ = ["Conditions", "SearchConditions"]


class SearchConditions(TypedDict, total=False):
    """Keyword arguments of searches and bounds, which know neither outages nor what detections truly are.

    >>> import pickline
    >>> line: pickline.SearchConditions = {"camera_x": -0.5, "grasp_success": 0.9}
    >>> pickline.optimize(patterns="balanced:4", items=30, validate=0, **line).runs
    36
    """

    update_hz: float
    """Decisions only at multiples of 1 / this [Hz]; 0 for any time."""
    camera_x: float | None
    """Position of the camera [m]; only items that have passed it are known."""
    min_detection: float
    """Items with a lower ``p_detection`` are left on the belt."""
    grasp_success: float | None
    """Grasps may fail; probability of success for items without ``p_grasp``."""
    position_noise: float
    """Standard deviation of reported positions [m]."""


class Conditions(SearchConditions, total=False):
    """Keyword arguments of runs, all of them optional."""

    misdetections: bool
    """Whether detections may be wrong."""
    outage: str | Iterable[str]
    """Times in which a robot makes no decision, each as after ``--outage`` of the program: ``"r2:30..60"``
    for robot r2, or the second one, from 30 s to 60 s."""
    outages: str | Iterable[float] | None
    """All robots fail at random: the mean time between failures and the mean time to repair [s], such as
    ``(300, 20)``."""


def conditions(
    *,
    update_hz: float = 0.0,
    camera_x: float | None = None,
    min_detection: float = 0.0,
    grasp_success: float | None = None,
    position_noise: float = 0.0,
    misdetections: bool = False,
    outage: str | Iterable[str] = (),
    outages: str | Iterable[float] | None = None,
) -> dict[str, Any]:
    """The conditions of runs with all their values."""
    return dict(
        update_hz=update_hz,
        camera_x=camera_x,
        min_detection=min_detection,
        grasp_success=grasp_success,
        position_noise=position_noise,
        misdetections=misdetections,
        outage=_outage_texts(outage),
        outages=_mean_times(outages),
    )


def search_conditions(
    *,
    update_hz: float = 0.0,
    camera_x: float | None = None,
    min_detection: float = 0.0,
    grasp_success: float | None = None,
    position_noise: float = 0.0,
) -> dict[str, Any]:
    """The conditions of searches and bounds, which know neither outages nor what detections truly are."""
    return conditions(
        update_hz=update_hz,
        camera_x=camera_x,
        min_detection=min_detection,
        grasp_success=grasp_success,
        position_noise=position_noise,
    )


def _outage_texts(outage: Any) -> list[str]:
    given = [outage] if isinstance(outage, str) else outage
    try:
        texts = list(given)
    except TypeError:
        texts = [given]
    for text in texts:
        if not isinstance(text, str):
            raise TypeError(f"outage: {text!r} is not a text\n  cure: give one such as 'r2:30..60', or a list of them")
    return texts


def _mean_times(outages: Any) -> str | tuple[float, ...] | None:
    if outages is None or isinstance(outages, str):
        return outages
    try:
        between, repair = (float(time) for time in outages)
    except (TypeError, ValueError):
        raise TypeError(
            f"outages: {outages!r} is not a pair of times\n  cure: give the mean time between failures and the "
            "mean time to repair [s], such as (300, 20)"
        ) from None
    return between, repair
