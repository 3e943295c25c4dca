"""Which robot picks what from a moving belt: stations, patterns, simulation and environments.

>>> import pickline
>>> station = pickline.Station("paper", robots=2)
>>> pattern = pickline.Pattern.grid(station, spacing=0.15, items=50)
>>> pickline.simulate(station, pattern, "SPT,FIFO").picked
44

``import pickline`` registers ``pickline/Sorting-v0`` with Gymnasium: see
:class:`pickline.environment.SortingEnv` and :class:`pickline.vector.SortingVectorEnv`.
"""

from pickline import _registration
from pickline._pickline import Pattern, Station, __version__, patterns
from pickline.environment import SortingEnv
from pickline.simulation import Picks, Simulation, simulate
from pickline.vector import SortingVectorEnv

_registration.register()

__all__ = [
    "Pattern",
    "Picks",
    "Simulation",
    "SortingEnv",
    "SortingVectorEnv",
    "Station",
    "__version__",
    "patterns",
    "simulate",
]
