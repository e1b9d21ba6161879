#!/usr/bin/env python3
"""Makes a report with a replay and looks at it in headless Chromium.

    replay_page_test.py BINPICK

One blind grasp is run, reported and opened at the width of a desktop and of a phone (500 px, the
least that headless Chromium makes): the 3-D view must start, draw something, follow the time
slider, and leave the console without errors; the page must not be wider than its window. Exit code
77 (skipped) without Chromium or without the 3-D view.
"""
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
CONFIG = """experiment: replay_page
title: One blind grasp
kind: blind_grasp
seed: 1
trials: 1
time_limit_s: 60
parameters:
  scene: {scene}
  grasp: top across wide axis
  pose_error: 0.015
"""
# Runs in the page: moves the slider to the end and leaves what is seen in the page's title.
PROBE = """
<script>
addEventListener('load', () => setTimeout(() => {
  const root = document.getElementById('replay');
  const canvas = root.querySelector('canvas');
  const colours = () => {
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [160, 90];
    const context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0, 160, 90);
    const data = new Uint32Array(context.getImageData(0, 0, 160, 90).data.buffer);
    return { distinct: new Set(data).size, sum: data.reduce((sum, pixel) => sum + pixel % 65521, 0) };
  };
  const slider = root.querySelector('input[type=range]');
  const clock = () => root.querySelector('output').textContent;
  const before = { ...colours(), clock: clock() };
  slider.value = slider.max;
  slider.dispatchEvent(new Event('input'));
  document.title = JSON.stringify({
    state: root.dataset.state, before, after: { ...colours(), clock: clock() },
    page: document.documentElement.scrollWidth, window: innerWidth,
  });
}, 500));
</script>
</body>"""


def browser():
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            return name
    return None


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(77)


def look(page, width):
    """What the probe saw in a window of this width, and what went to the console."""
    command = [browser(), "--headless", "--no-sandbox", "--use-angle=swiftshader",
               "--enable-unsafe-swiftshader", f"--window-size={width},900",
               "--virtual-time-budget=4000", "--enable-logging=stderr", "--dump-dom", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    errors = [line for line in done.stderr.splitlines() if ":CONSOLE" in line]
    title = re.search(r"<title>(\{.*?\})</title>", done.stdout)
    if not title:
        sys.exit(f"the page did not run:\n{done.stderr[-3000:]}")
    return json.loads(title.group(1)), errors


def main(binpick):
    if browser() is None:
        skip("no Chromium")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        config = folder / "replay_page.yaml"
        config.write_text(CONFIG.format(scene=REPOSITORY / "scenes/blind_bottle.yaml"))
        for command in (["run", config, "--out", folder / "out", "--workers", "1"],
                        ["report", folder / "out", "--replays", "1"]):
            subprocess.run([binpick, *command], check=True, capture_output=True, timeout=120)
        traces = sorted(file.name for file in (folder / "out/traces/all_0").iterdir())
        assert {"events.csv", "replay.json", "trace.csv", "trial.json"} <= set(traces), traces
        assert sum(name.endswith(".png") for name in traces) >= 2, traces
        report = (folder / "out/report.html").read_text(encoding="utf-8")
        if "Install npm" in report:
            skip("this build has no 3-D view")
        page = folder / "out/probed.html"
        page.write_text(report.replace("</body>", PROBE), encoding="utf-8")
        for width in (1200, 500):
            seen, errors = look(page, width)
            assert not errors, errors
            assert seen["state"] == "ready", seen
            assert seen["before"]["distinct"] > 100, seen
            assert seen["after"]["sum"] != seen["before"]["sum"], seen
            assert seen["after"]["clock"] != seen["before"]["clock"], seen
            assert seen["page"] <= seen["window"], seen
        print("the replay plays:", seen)


if __name__ == "__main__":
    main(sys.argv[1])
