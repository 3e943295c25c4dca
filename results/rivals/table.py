"""Prints the table of docs/rivals.md: look-ahead against the best-tuned rival, paired.

    python3 results/rivals/table.py --pickline PROGRAM [--stations A,B] [--replicates N] [--seed S]

Every station is run whole, then with each robot down for the whole run, for which the rival is tuned
again. A cell has the picks of rival and look-ahead on a pattern, and by how many percent of the rival's
look-ahead picks more. The interval is Student's for the differences of the picks on the same patterns.
The grid is one pattern, so it has none.
"""

import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import tempfile

CLASSES = ["--classes", "pet:0.3,hdpe:0.3,paper:0.2,wood:0.2"]
STATIONS = [("paper", 2, []), ("paper-narrow", 2, []), ("delta", 3, []), ("sorting", 4, CLASSES)]
TARGET = 10.0


def student(degrees: int) -> float:
    """The 97.5 % quantile of Student's distribution (Abramowitz and Stegun, 26.7.5)."""
    z, n = statistics.NormalDist().inv_cdf(0.975), degrees
    return (
        z
        + (z**3 + z) / (4 * n)
        + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * n**2)
        + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * n**3)
    )


def compare(program: str, station: str, flags: list[str]) -> tuple[str, dict]:
    """The rival, and for each case the picks of rival and look-ahead on each pattern."""
    with tempfile.TemporaryDirectory() as folder:
        words = f"compare --quiet --cases dense --station {station} --tune --reference rival"
        words += " --strategy lookahead --no-greedy --no-policy --no-bound --out"
        subprocess.run(
            [program, *words.split(), folder, *flags], check=True, stdout=subprocess.DEVNULL
        )
        notes = json.loads((pathlib.Path(folder) / "compare.json").read_text())["notes"]
        lines = (pathlib.Path(folder) / "runs.csv").read_text().splitlines()
    rival = next(note for note in notes if note.startswith("rival is "))
    rival = rival.removeprefix("rival is ").split(", the best of")[0]
    picks: dict = {}
    for row in csv.DictReader(line for line in lines if not line.startswith("#")):
        picks.setdefault(row["case"], {}).setdefault(row["method"], []).append(int(row["picked"]))
    return rival, {case: (of["rival"], of["lookahead"]) for case, of in picks.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pickline", default="pickline")
    parser.add_argument("--stations", default=",".join(name for name, _, _ in STATIONS))
    parser.add_argument("--replicates", default="20")
    parser.add_argument("--seed", default="1")
    given = parser.parse_args()
    usual = ["--replicates", given.replicates, "--seed", given.seed]
    gains = []
    chosen = given.stations.split(",")
    for station, robots, flags in (line for line in STATIONS if line[0] in chosen):
        for halted in [None, *(f"r{robot + 1}" for robot in range(robots))]:
            outage = ["--outage", f"{halted}:0.."] if halted else []
            rival, cases = compare(given.pickline, station, [*usual, *flags, *outage])
            if not gains:
                # The cases are the same on every station; all have 150 items.
                names = [case.split(",")[0] for case in cases]
                print("| station | halted | rival |", *(f"{name} |" for name in names))
                print("|---|---|---|" + "---|" * len(names))
            cells = []
            for theirs, ours in cases.values():
                means = statistics.mean(theirs), statistics.mean(ours)
                more = [100 * (b - a) / means[0] for a, b in zip(theirs, ours)]
                low = gain = statistics.mean(more)
                text = f"{means[0]:.1f}, {means[1]:.1f}: {gain:.1f}"
                if len(more) > 1:
                    half = student(len(more) - 1) * statistics.stdev(more) / len(more) ** 0.5
                    low = gain - half
                    text += f" ({gain - half:.1f} to {gain + half:.1f})"
                gains.append((gain, low))
                cells.append(text)
            row = [station, halted or "none", f"`{rival}`", *cells]
            print("|", " | ".join(row), "|", flush=True)
    reached = sum(gain >= TARGET for gain, _ in gains)
    above = sum(low > 0 for _, low in gains)
    print(f"\nat least {TARGET:.0f} % more: {reached} of {len(gains)}; interval above 0: {above}")


main()
