"""What all results have, and how work that is interrupted hands over its result."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from inspect import signature
from typing import Any, Self

from pickline import _pickline
from pickline._html import in_notebook

__all__ = ["Interrupted", "KeptReport", "Result"]


@dataclass(frozen=True, eq=False, repr=False)
class KeptReport:
    """A report that was pickled: the forms that it had, in another process."""

    _text: str
    _csv: str
    _json: str
    _page: str | None
    _tables: dict[str, dict[str, tuple[str, Any]]]
    interrupted: bool
    """Whether Ctrl-C ended the work early."""

    def text(self) -> str:
        """The text that the program prints."""
        return self._text

    def csv(self) -> str:
        """The main table as CSV."""
        return self._csv

    def json(self) -> str:
        """The whole report as JSON."""
        return self._json

    def page(self) -> str | None:
        """The page with tables and charts, or the replay of a run; None if there is none."""
        return self._page

    def tables(self) -> dict[str, dict[str, tuple[str, Any]]]:
        """The columns of every CSV file of the report."""
        return self._tables


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended the work early.

    A ``KeyboardInterrupt`` with what was found by then, as the program would print it.
    """

    def __init__(self, partial: Result) -> None:
        super().__init__("interrupted; `partial` is what was found by then")
        self.partial = partial
        """The result so far."""

    def __reduce__(self) -> tuple[type[Interrupted], tuple[Result]]:
        return type(self), (self.partial,)


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """What a call found: ``print`` shows the table of the program."""

    report: _pickline.Report | KeptReport = field(kw_only=True)
    """The report, from which every other form is made."""

    @classmethod
    def _of(cls, report: _pickline.Report) -> Self:
        """The result of a call; raises Interrupted with it if Ctrl-C ended the call early."""
        result = cls(**cls._parts(json.loads(report.json()), report.tables()), report=report)
        if report.interrupted:
            raise Interrupted(result)
        return result

    @classmethod
    def _parts(cls, document: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
        """The fields from the report's document and tables."""
        raise NotImplementedError

    def to_csv(self) -> str:
        """The main table as the program's CSV, with comments on where it comes from."""
        return self.report.csv()

    def to_json(self) -> str:
        """Everything, as the program's JSON."""
        return self.report.json()

    def to_html(self) -> str | None:
        """The page with tables and charts that the program writes; None if there is none."""
        return self.report.page()

    def __str__(self) -> str:
        return self.report.text()

    def _repr_html_(self) -> str:
        return in_notebook(self.report.page(), self.report.text(), repr(self))


def partial(document: dict[str, Any]) -> str | None:
    """How far the work got, if it was interrupted."""
    return document["made"].get("partial")


def call_text(function: Callable[..., Any], given: dict[str, Any]) -> str:
    """The call as results name it: with the arguments that are not usual and change the result."""
    usual = {name: known.default for name, known in signature(function).parameters.items()}
    given = given | given.get("under", {})
    hidden = ("pattern", "progress", "under")
    words = [
        f"{name}={_shown(value)}"
        for name, value in given.items()
        if name not in hidden and not _is_usual(value, usual.get(name, usual))
    ]
    return f"pickline.{function.__name__}({', '.join(words)})"


def _is_usual(value: Any, usual: Any) -> bool:
    """Whether an argument has its default."""
    try:
        return bool(value == usual)
    except Exception:
        # Arrays and series compare entry by entry, or refuse to.
        return False


def _shown(value: Any) -> str:
    """A value in a call; a callable by its name, because its address changes from run to run."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        if value and all(isinstance(entry, _pickline.Pattern) for entry in value):
            return f"<{len(value)} patterns>"
        return f"[{', '.join(map(_shown, value))}]"
    if callable(value):
        return getattr(value, "__name__", type(value).__name__)
    text = repr(value)
    # An address changes from run to run.
    return f"<{type(value).__name__}>" if " at 0x" in text else text
