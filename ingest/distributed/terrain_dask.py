#!/usr/bin/env python3
"""Builds an archive on a Dask cluster: every job of `terrain-ingest plan` is a task, stage by stage.

    terrain_dask.py DEM… --work s3://bucket/work -o all.pmtiles --scheduler tcp://host:8786 -- --max-error 5

Without --scheduler it starts workers on this machine. What stands behind `--` goes to `terrain-ingest plan`. Workers need the
program and the store; the paths of the rasters must be the same on all of them. A job that fails or whose worker dies is run
again: what is finished is in the store and is not done twice.
"""

import argparse
import json
import subprocess
import sys

from dask.distributed import Client, LocalCluster, as_completed


class JobFailed(Exception):
    """A job said why it failed."""


def terrain_ingest(program, *arguments):
    """Runs the program; what it printed. Raises JobFailed with its last line of standard error."""
    done = subprocess.run([program, *arguments, "--quiet"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise JobFailed(f"{arguments[0]} {' '.join(arguments[1:])}: {lines[-1]}")
    return done.stdout


def run_job(job, program, work):
    """One job, on a worker."""
    terrain_ingest(program, "build", "--work", work, "--job", job, "--jobs", "1")
    return job


def run_stage(client, stage, program, work, retries, tell):
    """All jobs of a stage, in any order."""
    name, count = stage["stage"], stage["jobs"]
    jobs = [f"{name}/{number}" for number in range(count)]
    tasks = client.map(run_job, jobs, program=program, work=work, pure=False, retries=retries)
    for done, task in enumerate(as_completed(tasks), start=1):
        task.result()
        tell(f"{name}: {done} of {count}")


def build(client, rasters, work, output, program="terrain-ingest", options=(), retries=2, tell=lambda line: None):
    """Builds `output` of `rasters` by the workers of `client`; the program's report as a dictionary."""
    plan = json.loads(terrain_ingest(program, "plan", *rasters, "--work", work, *options, "--json"))
    for stage in plan["stages"]:
        run_stage(client, stage, program, work, retries, tell)
    return json.loads(terrain_ingest(program, "merge", "--work", work, "-o", output, "--json"))


def parsed(arguments):
    """The options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rasters", nargs="+", metavar="DEM")
    parser.add_argument("--work", required=True, help="the store that all workers share: a folder or a bucket")
    parser.add_argument("-o", "--output", required=True, metavar="OUT.pmtiles")
    parser.add_argument("--scheduler", help="address of a Dask scheduler; workers on this machine if not given")
    parser.add_argument("--workers", type=int, help="how many of these; one a core if not given")
    parser.add_argument("--program", default="terrain-ingest", help="the program's path on the workers")
    own, _, of_plan = arguments_before_dashes(arguments)
    return parser.parse_args(own), of_plan


def arguments_before_dashes(arguments):
    """What stands before `--`, the dashes, and what stands behind them."""
    at = arguments.index("--") if "--" in arguments else len(arguments)
    return arguments[:at], arguments[at : at + 1], arguments[at + 1 :]


def main():
    """The command line."""
    options, of_plan = parsed(sys.argv[1:])
    cluster = options.scheduler or LocalCluster(n_workers=options.workers, threads_per_worker=1)
    tell = lambda line: print(line, file=sys.stderr)
    with Client(cluster) as client:
        try:
            report = build(client, options.rasters, options.work, options.output, options.program, of_plan, tell=tell)
        except JobFailed as failed:
            sys.exit(f"error: {failed}")
    print(f"{report['output']}: {report['tile_bytes'] / 1e6:.1f} MB of tiles")


if __name__ == "__main__":
    main()
