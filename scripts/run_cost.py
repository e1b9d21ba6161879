#!/usr/bin/env python3
"""What a run spends beside its trials: processor time of the parent process (store, progress,
worker management, tables, report) as a share of the whole run's.

    python3 scripts/run_cost.py build/release/binpick run experiments/table1.yaml --fresh
"""
import os
import resource
import subprocess
import sys
import time


def main(command):
    if not command or command[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if command else 2
    tick = os.sysconf("SC_CLK_TCK")
    parent = 0.0
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
        while run.poll() is None:
            with open(f"/proc/{run.pid}/stat", encoding="ascii") as stat:
                fields = stat.read().rsplit(")", 1)[1].split()
            # Fields 14 and 15 of proc(5); a process that has ended shows zeros.
            parent = max(parent, (int(fields[11]) + int(fields[12])) / tick)
            time.sleep(0.01)
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    total = usage.ru_utime + usage.ru_stime
    print(f"parent {parent:.2f} s of {total:.1f} s of processor time: {100 * parent / total:.2f} %")
    return run.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
