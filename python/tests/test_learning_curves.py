"""The learning curves in docs/rl.md are those of the committed trainings."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_committed_picture_and_figures_are_made_again(tmp_path):
    picture = tmp_path / "curves.svg"
    command = [sys.executable, "python/benchmarks/learning_curves.py", "results/sb3", "--out", picture]
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert picture.read_text() == (ROOT / "results/sb3/curves.svg").read_text()
    assert len(printed.splitlines()) >= 2
    assert f"```\n{printed}```" in (ROOT / "docs/rl.md").read_text()
