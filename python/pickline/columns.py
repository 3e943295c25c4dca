"""Tables, one array a column."""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pickline import _pickline

__all__ = ["Columns", "sealed", "texts"]

# What columns hold.
Texts = NDArray[np.object_]
Counts = NDArray[np.int64]
Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Columns:
    """A table with a field for each column; every column has a value for each row [rows].

    Numbers are float64, NaN where a row has none; counts are int64, or uint64 if a seed does not fit,
    and float64 if a row has none; texts are arrays of ``str`` with dtype object. A column that the
    program leaves out of its CSV file is None. The arrays are read-only; ``copy`` them to change them.
    """

    names: Mapping[str, str] = field(default_factory=dict, repr=False, kw_only=True)
    """The names in the program's CSV file of those columns that have another one there."""

    def __post_init__(self) -> None:
        sealed(self)

    @classmethod
    def _read(cls, table: Mapping[str, tuple[str, Any]]) -> Self:
        """The table of what a report has."""
        values, names = {}, {}
        for column, (name, given) in table.items():
            key = f"item_{column}" if keyword.iskeyword(column) else column
            if isinstance(given, list):
                given = texts(given)
            values[key] = given
            if name != key:
                names[key] = name
        for column in fields(cls):
            values.setdefault(column.name, None)
        return cls(**values | {"names": names})

    @classmethod
    def _read_any(cls, table: Mapping[str, tuple[str, Any]] | None) -> Self | None:
        return None if table is None else cls._read(table)

    def to_dict(self) -> dict[str, NDArray[Any]]:
        """The columns by their names in the program's CSV file."""
        columns = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "names"}
        return {
            self.names.get(name, name): values
            for name, values in columns.items()
            if values is not None
        }

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with the names of :meth:`to_dict`; texts are ``str``."""
        try:
            import pandas
        except ImportError:
            raise ImportError(
                "to_pandas: pandas is not installed\n  cure: pip install pandas, or take to_dict()"
            ) from None
        return pandas.DataFrame(self.to_dict())

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The table for readers of Arrow, such as ``polars.DataFrame(table)``.

        Names are those of :meth:`to_dict`. Another schema than the table's own is not made.
        """
        return _pickline.arrow_stream(self.to_dict())

    def __len__(self) -> int:
        return len(next(iter(self.to_dict().values())))


def sealed(result: Any) -> None:
    """Makes the arrays among the fields of a dataclass read-only, as its fields are."""
    for column in fields(result):
        values = getattr(result, column.name)
        if isinstance(values, np.ndarray):
            values.setflags(write=False)


def texts(values: list[str]) -> NDArray[np.object_]:
    """An array of texts."""
    array = np.empty(len(values), object)
    array[:] = values
    return array
