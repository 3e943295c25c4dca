"""What notebooks show of results."""

import html
import re

import pytest

import pickline

CALLS = {
    "compare": lambda: pickline.compare(replicates=2, robust="SPT,FIFO", bound=False),
    "sweep": lambda: pickline.sweep(robust="SPT,FIFO", from_=0.03, to=0.06, step=0.01),
    "optimize": lambda: pickline.optimize(patterns="grid:0.2", items=20, validate=0, bound=False),
    "simulate": lambda: pickline.simulate("paper", pickline.Pattern.grid(1.05, 0.15, 50)),
}


@pytest.mark.parametrize("name", CALLS)
def test_pages_are_those_of_the_program_in_a_frame(name):
    result = CALLS[name]()
    shown = result._repr_html_()
    frame = re.fullmatch(r'<iframe srcdoc="([^"]*)"([^<>]*)></iframe>', shown, re.DOTALL)
    assert frame and 'sandbox="allow-scripts"' in frame[2]
    page = html.unescape(frame[1])
    assert page == result.report.page()
    assert page.startswith("<!doctype html>") and f"pickline.{name}(" in page
    # Nothing is loaded from anywhere, and dark schemes are known.
    assert not re.search(r'(src|href)="(https?:)?//', page)
    assert "prefers-color-scheme: dark" in page
    assert name == "simulate" or page.count("<svg") >= 1


def test_a_page_too_large_for_a_notebook_is_left_out():
    result = pickline.simulate("paper", pickline.Pattern.grid(1.05, 0.15, 10_000))
    shown = result._repr_html_()
    assert len(shown) < 10_000 and shown.startswith(f"<pre>{html.escape(str(result))}</pre>")
    assert "to_html()" in shown and len(result.to_html()) > 2_000_000


def test_results_without_a_page_are_shown_as_text():
    pattern = pickline.Pattern([0.0, -0.2], [0.1, 0.1], id=["<b>", "c"])
    found = pickline.bound("paper", pattern)
    shown = found._repr_html_()
    assert shown == f"<pre>{html.escape(str(found))}</pre>" and "bound" in shown
