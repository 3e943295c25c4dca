"""Results in notebooks."""

from __future__ import annotations

from html import escape

# A frame keeps the page's style and scripts to itself; the reader can make it higher.
_FRAME = (
    '<iframe srcdoc="{page}" sandbox="allow-scripts" title="{title}" '
    'style="width: 100%; height: 640px; border: 0; resize: vertical; overflow: auto"></iframe>'
)

# A notebook keeps what it shows. The replay of a long run is too much for that.
_MOST_CHARACTERS = 2_000_000


def in_notebook(page: str | None, text: str, title: str) -> str:
    """The program's page for a notebook, or its text where it has no page."""
    if page is None:
        return f"<pre>{escape(text)}</pre>"
    if len(page) > _MOST_CHARACTERS:
        size = f"The page has {len(page) / 1e6:.1f} MB: write <code>to_html()</code> to a file to see it."
        return f"<pre>{escape(text)}</pre><p>{size}</p>"
    return _FRAME.format(page=escape(page), title=escape(title))
