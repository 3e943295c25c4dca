"""The notebooks run, and their committed output is what they print."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[1] / "notebooks"
# What needs torch is tested in sb3/.
NOTEBOOKS = sorted(path for path in FOLDER.glob("*.ipynb") if path.stem != "3-train-with-sb3")


def texts(notebook):
    """What each cell shows as text: everything printed at once, because a kernel sends it in pieces as
    time allows, then what it shows."""
    return [
        [
            "".join(output.text for output in cell.outputs if output.output_type == "stream"),
            *(output.data.get("text/plain") for output in cell.outputs if "data" in output),
        ]
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_output_is_what_the_cells_print(path):
    committed = nbformat.read(path, as_version=4)
    fresh = nbformat.from_dict(committed)
    kernel = {"kernel_name": "python3", "resources": {"metadata": {"path": str(FOLDER)}}}
    NotebookClient(fresh, timeout=600, **kernel).execute()
    assert texts(fresh) == texts(committed)
    assert sum(bool(text) for cell in texts(committed) for text in cell) >= 2


def test_there_are_notebooks():
    assert len(NOTEBOOKS) == len(list(FOLDER.glob("*.ipynb"))) - 1 >= 3
