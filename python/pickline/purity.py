"""What truly went into the bins: the columns that tables of purity share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickline.columns import Columns

__all__ = ["Purities"]


@dataclass(frozen=True, eq=False)
class Purities(Columns):
    """How pure bins are, and how much of what is due is in them.

    A table lists it before the class of its first columns: fields are those of the last base first.
    """

    binned: NDArray[np.int64]
    """Number of items in the bin, or in all of them."""
    rightly_binned: NDArray[np.int64]
    """Number of those that belong there."""
    due: NDArray[np.int64]
    """Number of items that belong there."""
    purity: NDArray[np.float64]
    """Share of what is binned that belongs there, 0 to 1."""
    purity_low: NDArray[np.float64]
    """Lower end of its 95 % interval."""
    purity_high: NDArray[np.float64]
    """Upper end of its 95 % interval."""
    recovery: NDArray[np.float64]
    """Share of what is due that is binned rightly, 0 to 1."""
    recovery_low: NDArray[np.float64]
    """Lower end of its 95 % interval."""
    recovery_high: NDArray[np.float64]
    """Upper end of its 95 % interval."""
