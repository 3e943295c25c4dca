"""Prints the table of docs/lookahead.md on one arm: look-ahead against dispatching rules, paired.

    python3 results/single-arm/table.py

It reads `runs.csv` of the comparisons in this folder, which `bash results/make.sh` makes. A cell has the
picked share [%] of a method, and by how many percent of its picks look-ahead picks more, with Student's
95 % interval of the mean difference of the picks on the same patterns.
"""

import csv
import pathlib
import statistics

FOLDER = pathlib.Path(__file__).parent
RULES = ["rules:FIFO", "rules:SPT", "greedy_gt"]
# The 97.5 % quantile of Student's distribution with 99 degrees of freedom.
STUDENT = 1.984


def main() -> None:
    print("| arm | items arrive | FIFO | SPT | best rule of each pattern | look-ahead |")
    print("|---|---|---|---|---|---|")
    for arm in ("delta", "scara"):
        lines = (FOLDER / arm / "runs.csv").read_text().splitlines()
        picks: dict = {}
        for row in csv.DictReader(line for line in lines if not line.startswith("#")):
            method = "rules:FIFO" if row["method"] == "robust_gt" else row["method"]
            of_case = picks.setdefault(row["case"], {})
            of_case.setdefault(method, []).append((int(row["picked"]), int(row["items"])))
        for case, methods in picks.items():
            share = {name: 100 * sum(p for p, _ in of) / sum(n for _, n in of) for name, of in methods.items()}
            ahead = [picked for picked, _ in methods["lookahead"]]
            assert len(ahead) == 100
            cells = []
            for name in RULES:
                rule = [picked for picked, _ in methods[name]]
                more = [a - b for a, b in zip(ahead, rule, strict=True)]
                half = STUDENT * statistics.stdev(more) / len(more) ** 0.5
                mean = statistics.mean(more)
                percent = 100 / statistics.mean(rule)
                low, high = percent * (mean - half), percent * (mean + half)
                cells.append(f"{share[name]:.1f} (+{percent * mean:.1f}, {low:.1f} to {high:.1f})")
            print(f"| {arm} | {case} | {' | '.join(cells)} | {share['lookahead']:.1f} |")


main()
