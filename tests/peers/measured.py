"""Runs COMMAND and writes what it cost, and nothing but it, to REPORT: `python3 measured.py REPORT COMMAND…`

A program of its own, because a process starts with the peak memory of the one that it was forked from; this one stays
small.
"""

import json
import os
import sys


def main() -> int:
    report, *command = sys.argv[1:]
    process = os.posix_spawnp(command[0], command, os.environ)
    _, status, usage = os.wait4(process, 0)
    cost = {"cpu_seconds": usage.ru_utime + usage.ru_stime, "peak_megabytes": usage.ru_maxrss * 1024 / 1e6}
    with open(report, "w", encoding="utf-8") as file:
        json.dump(cost, file)
    return 0 if status == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
