"""Which robot picks what from a moving belt: stations, patterns, simulation and environments.

>>> import pickline
>>> station = pickline.Station("paper", robots=2)
>>> pattern = pickline.Pattern.grid(station, spacing=0.15, items=50)
>>> pickline.simulate(station, pattern, "SPT,FIFO").picked
44

Long calls take ``progress``: True shows a bar by tqdm (``pip install tqdm``), a callable is called with
the steps done, the steps in total and what is being done, about twenty times a second at most.
Ctrl-C ends them with :class:`pickline.Interrupted`, a ``KeyboardInterrupt`` whose ``partial`` is what was
found by then.

``import pickline`` registers ``pickline/Sorting-v0`` with Gymnasium: see
:class:`pickline.environment.SortingEnv` and :class:`pickline.vector.SortingVectorEnv`.
"""

from pickline import _registration
from pickline._pickline import (
    Pattern,
    Station,
    __version__,
    learning_curves,
    patterns,
    trials,
)
from pickline.bounds import Bound, Prices, bound
from pickline.columns import Columns
from pickline.comparison import (
    CaseClasses,
    CasePurities,
    Comparison,
    PickedTimes,
    PickingRates,
    Runs,
    Throughputs,
    compare,
)
from pickline.conditions import Conditions, SearchConditions
from pickline.environment import SortingEnv
from pickline.halted import HaltedPoints, RobotsDown, robots_down
from pickline.offline import to_minari
from pickline.optimum import Optimum, Ranking, ScoredStrategies, optimize
from pickline.recordings import Import, import_mot
from pickline.result import Interrupted, Result
from pickline.simulation import Picks, Simulation, simulate
from pickline.strategy import Snapshot, Wait
from pickline.sweeps import (
    Limits,
    Points,
    Sweep,
    SweptClasses,
    SweptPurities,
    Thresholds,
    sweep,
)
from pickline.vector import SortingVectorEnv
from pickline.verification import Verification, Violations, check

_registration.register()

__all__ = [
    "Bound",
    "CaseClasses",
    "CasePurities",
    "Columns",
    "Comparison",
    "Conditions",
    "HaltedPoints",
    "Import",
    "Interrupted",
    "Limits",
    "Optimum",
    "Pattern",
    "PickedTimes",
    "PickingRates",
    "Picks",
    "Points",
    "Prices",
    "Ranking",
    "Result",
    "RobotsDown",
    "Runs",
    "ScoredStrategies",
    "SearchConditions",
    "Simulation",
    "Snapshot",
    "SortingEnv",
    "SortingVectorEnv",
    "Station",
    "Sweep",
    "SweptClasses",
    "SweptPurities",
    "Thresholds",
    "Throughputs",
    "Verification",
    "Violations",
    "Wait",
    "__version__",
    "bound",
    "check",
    "compare",
    "import_mot",
    "learning_curves",
    "optimize",
    "patterns",
    "robots_down",
    "simulate",
    "sweep",
    "to_minari",
    "trials",
]
