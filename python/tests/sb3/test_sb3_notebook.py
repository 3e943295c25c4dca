"""The notebook that needs torch; run.sh installs what it needs, which is no Jupyter."""

import contextlib
import io
import json
from pathlib import Path

FOLDER = Path(__file__).parents[2] / "notebooks"


def test_the_output_is_what_the_cells_print(monkeypatch):
    monkeypatch.chdir(FOLDER)
    notebook = json.loads(Path("3-train-with-sb3.ipynb").read_text())
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names = {"__name__": "__main__"}
    printing = 0
    for cell in cells:
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown):
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
        # All of its output is printed.
        committed = "".join("".join(output["text"]) for output in cell["outputs"])
        assert shown.getvalue() == committed, cell["id"]
        printing += bool(committed)
    assert printing >= 4
