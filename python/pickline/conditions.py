"""The conditions of runs: what is known, and what may go wrong."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any, ParamSpec, TypedDict, TypeVar

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


P = ParamSpec("P")
R = TypeVar("R")


def naming(read: Callable[P, R]) -> Callable[P, R]:
    """``read``, which says of an argument that it does not have which ones there are."""
    known = list(inspect.signature(read).parameters)

    @functools.wraps(read)
    def checked(*args: P.args, **given: P.kwargs) -> R:
        for name in given:
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                cure = f"did you mean {near[0]}?" if near else f"the conditions are {', '.join(known)}"
                raise TypeError(f"{name}: there is no such argument\n  cure: {cure}")
        return read(*args, **given)

    return checked


@naming
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
    """The conditions of runs with all their values; a misspelled one is a ``TypeError``."""
    return dict(
        update_hz=update_hz,
        camera_x=camera_x,
        min_detection=min_detection,
        grasp_success=grasp_success,
        position_noise=position_noise,
        misdetections=misdetections,
        outage=[outage] if isinstance(outage, str) else list(outage),
        outages=outages if outages is None or isinstance(outages, str) else tuple(outages),
    )


@naming
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
