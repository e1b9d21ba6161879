#!/usr/bin/env python3
"""Tests scripts/sensitivity_table.py on made-up runs whose truth is known."""
import random
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "sensitivity_table.py"


def write_run(folder, rate_of, trials=300):
    draw = random.Random(7)
    lines = ["cell,K_t_y,K_r_x,reaction,trial,outcome,stage,note"]
    for k_t in ("200", "750", "2000"):
        for k_r in ("20", "75", "200"):
            for reaction in ("true", "false"):
                for trial in range(trials):
                    good = draw.random() < rate_of(k_t, k_r, reaction)
                    outcome = "success" if good else "slipped"
                    lines.append(f'"x",{k_t},{k_r},{reaction},{trial},{outcome},judge,')
    folder.mkdir()
    (folder / "trials.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def table(folder):
    result = subprocess.run([sys.executable, SCRIPT, folder], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    rows = [line.strip("| \n").split(" | ") for line in result.stdout.splitlines()[2:]]
    return {row[1]: row for row in rows}


class SensitivityTable(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def verdicts(self, name, rate_of):
        write_run(self.folder / name, rate_of)
        rows = table(self.folder / name)
        return {line: [text.split()[0] for text in row[4:]] for line, row in rows.items()}, rows

    def test_a_clear_effect_is_confirmed_and_its_opposite_contradicted(self):
        soft = {"200": 0.9, "750": 0.7, "2000": 0.5}
        found, rows = self.verdicts(
            "clear", lambda k_t, k_r, on: soft[k_t] if on == "true" else 1.4 - soft[k_t])
        self.assertEqual(found["reaction true"][:2], ["yes", "yes"])
        self.assertEqual(found["reaction false"][:2], ["NO", "NO"])
        self.assertIn("2700", rows["reaction true"][2])

    def test_a_flat_table_decides_nothing(self):
        found, rows = self.verdicts("flat", lambda k_t, k_r, on: 0.67)
        self.assertEqual(found["reaction true"], ["-", "-", "-"])
        low, high = rows["reaction true"][3].split("[")[1].strip("]").split(", ")
        self.assertLess(float(low), 67)
        self.assertGreater(float(high), 67)

    def test_an_unfinished_run_is_refused(self):
        result = subprocess.run([sys.executable, SCRIPT, self.folder], capture_output=True)
        self.assertEqual(result.returncode, 2)


if __name__ == "__main__":
    unittest.main()
