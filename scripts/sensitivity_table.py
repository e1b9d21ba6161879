#!/usr/bin/env python3
"""How Table 1's rates and claims move with a parameter: one line per value, as Markdown.

    python3 scripts/sensitivity_table.py DIR...

Each DIR is a finished results folder (its trials.csv) of a blind-grasp experiment with the axes
K_t_y and K_r_x of Table 1; other axes, such as the swept parameter and `reaction`, make the lines.

The claims are those that the paper's Table 1 suggests:
  a  soft is better: the mean rate at K_t_y = 200 N/m exceeds that at 2000 N/m
  b  the best cell is soft: the best rate at 200 N/m exceeds the best of the other cells
  c  cells 2, 3 and 5 (200/75, 200/200, 750/75) are better on average than the other six
Each is a difference of rates with a 95 % interval from 2000 bootstrap resamples of the trial
numbers, which all cells share (common random numbers), and its two-sided bootstrap p value. With
Holm's correction over the three at 5 %: `yes` confirmed, `NO` contradicted, `-` undecided.
Reproducible: the resampling has a fixed seed.
"""
import csv
import math
import random
import sys
from collections import defaultdict
from pathlib import Path

RESAMPLES = 2000
SOFT, STIFF = "200", "2000"
NAMED_CELLS = {("200", "75"), ("200", "200"), ("750", "75")}
NOT_AXES = {"cell", "trial", "outcome", "stage", "note"}


def wilson(successes, trials):
    z = 1.959963984540054
    p = successes / trials
    centre = (p + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * math.sqrt(p * (1 - p) / trials + (z / (2 * trials)) ** 2)
    return max(0.0, centre - half), min(1.0, centre + half)


def read_lines(folder):
    """Per combination of the other axes: cell (K_t_y, K_r_x) -> trial number -> success."""
    with open(folder / "trials.csv", newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        header = reader.fieldnames
        axes = header[1 : header.index("trial")]
        others = [axis for axis in axes if axis not in ("K_t_y", "K_r_x")]
        lines = defaultdict(lambda: defaultdict(dict))
        for row in reader:
            key = tuple((axis, row[axis]) for axis in others)
            cell = (row["K_t_y"], row["K_r_x"])
            lines[key][cell][int(row["trial"])] = row["outcome"] == "success"
    return lines


def mean(values):
    return sum(values) / len(values)


def claims_of(rates):
    """The three differences, from the rate of each cell."""
    soft = [rate for (k_t, _), rate in rates.items() if k_t == SOFT]
    stiff = [rate for (k_t, _), rate in rates.items() if k_t == STIFF]
    others = [rate for (k_t, _), rate in rates.items() if k_t != SOFT]
    named = [rate for cell, rate in rates.items() if cell in NAMED_CELLS]
    unnamed = [rate for cell, rate in rates.items() if cell not in NAMED_CELLS]
    return (mean(soft) - mean(stiff), max(soft) - max(others), mean(named) - mean(unnamed))


def rates_of(cells, numbers):
    return {cell: mean([trials[i] for i in numbers]) for cell, trials in cells.items()}


def bootstrap(cells):
    """Per claim: estimate, interval and p value."""
    numbers = sorted(set.intersection(*(set(trials) for trials in cells.values())))
    estimates = claims_of(rates_of(cells, numbers))
    draw = random.Random(1)
    samples = [
        claims_of(rates_of(cells, draw.choices(numbers, k=len(numbers)))) for _ in range(RESAMPLES)
    ]
    results = []
    for claim, estimate in enumerate(estimates):
        values = sorted(sample[claim] for sample in samples)
        low, high = values[int(0.025 * RESAMPLES)], values[int(0.975 * RESAMPLES)]
        below = sum(value <= 0 for value in values)
        above = sum(value >= 0 for value in values)
        p = min(1.0, 2.0 * (min(below, above) + 1) / (RESAMPLES + 1))
        results.append((estimate, low, high, p))
    return results


def verdicts(results):
    """Holm: the smallest p against 5 % / 3, the next against 5 % / 2, ... until one fails."""
    words = ["-"] * len(results)
    order = sorted(range(len(results)), key=lambda claim: results[claim][3])
    for rank, claim in enumerate(order):
        if results[claim][3] > 0.05 / (len(results) - rank):
            break
        words[claim] = "yes" if results[claim][0] > 0 else "NO"
    return words


def table_row(name, line, cells):
    successes = sum(sum(trials.values()) for trials in cells.values())
    count = sum(len(trials) for trials in cells.values())
    low, high = wilson(successes, count)
    texts = [name, ", ".join(f"{axis} {value}" for axis, value in line), str(count),
             f"{100 * successes / count:.1f} [{100 * low:.1f}, {100 * high:.1f}]"]
    results = bootstrap(cells)
    for (estimate, lowest, highest, _), verdict in zip(results, verdicts(results)):
        texts.append(f"{verdict} {100 * estimate:+.0f} [{100 * lowest:+.0f}, {100 * highest:+.0f}]")
    return "| " + " | ".join(texts) + " |"


def main(folders):
    if not folders or folders[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if folders else 2
    print("| run | line | trials | rate, % | a soft is better | b best cell is soft | c named cells |")
    print("|---|---|---|---|---|---|---|")
    for folder in map(Path, folders):
        try:
            lines = read_lines(folder)
        except (OSError, KeyError, ValueError) as error:
            print(f"{folder}: no finished run of Table 1's cells ({error})", file=sys.stderr)
            return 2
        for line, cells in lines.items():
            print(table_row(folder.name, line, cells), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
