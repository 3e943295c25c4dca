"""Holds pickline to the SimPy program of line.py: the same picks, with times that are equal to the bit.

usage: equal.py PICKLINE
"""

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from line import Line, Pick, read_pattern, read_station

# Station, number of robots, belt speed [m/s], pattern, rule assignments.
ALL_OF_TWO = [",".join(rules) for rules in itertools.product(["FIFO", "SPT", "LPT", "SD", "LD", "PP"], repeat=2)]
SIX = "FIFO,SPT,LPT,SD,LD,PP"
CASES = [
    ("paper", 2, 0.05, "grid --spacing 0.15 --count 150", ALL_OF_TWO),
    ("paper", 2, 0.08, "poisson --radius 0.15 --count 60 --seed 1", ["SPT,FIFO", "SD,PP"]),
    ("paper", 6, 0.3, "random --flow 400 --count 200 --seed 2", [SIX]),
    ("paper-narrow", 3, 0.1, "clustered --flow 120 --count 80 --seed 3", ["LD,SPT,SD"]),
    # Workspaces that overlap: robots take items from each other.
    ("crowded", 2, 0.05, "grid --spacing 0.15 --count 100", ["SPT,FIFO", "LD,SD", "FIFO,FIFO"]),
]


def crowded(paper: str) -> str:
    """The station with its second robot 1.2 m further upstream, where the first one works."""
    return paper.replace("2.9000000000000004", "1.7000000000000004")


def picks_of(pickline: str, station: str, pattern: str, rules: str) -> list[Pick]:
    """The picks of `pickline simulate`, in order of decision."""
    command = [pickline, "simulate", "--quiet", "--no-bound", "--station", station, "--pattern", pattern]
    command += ["--strategy", f"rules:{rules}", "--format", "json"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [
        Pick(pick["robot"], int(pick["item"]) - 1, pick["decide_s"], pick["grasp_s"], pick["release_s"])
        for pick in json.loads(printed)["picks"]
    ]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        compare(sys.argv[1], Path(folder))


def compare(pickline: str, folder: Path) -> None:
    ask = lambda *words: subprocess.run([pickline, *words], check=True, capture_output=True, text=True).stdout
    runs, taken_away = 0, 0
    for name, robots, speed, kind, assignments in CASES:
        built_in = "paper" if name == "crowded" else name
        shown = ask("station", "show", "--station", built_in, "--robots", str(robots), "--belt-speed", str(speed))
        station, pattern = folder / "station.toml", folder / "pattern.csv"
        station.write_text(crowded(shown) if name == "crowded" else shown)
        pattern.write_text(ask("pattern", "generate", *kind.split(), "--station", str(station)))
        line = Line(read_station(station.read_text()), read_pattern(pattern.read_text()))
        for rules in assignments:
            own = line.run(rules.split(","))
            its = picks_of(pickline, str(station), str(pattern), rules)
            where = f"{name}, {kind}, {rules}"
            assert len({pick.robot for pick in own}) > 1, f"{where}: only one robot picks"
            for place, (a, b) in enumerate(itertools.zip_longest(own, its)):
                assert a == b, f"{where}: pick {place}: SimPy {a}, pickline {b}"
            runs += 1
    print(f"{runs} runs: the picks of pickline are those of SimPy, to the bit")


if __name__ == "__main__":
    main()
