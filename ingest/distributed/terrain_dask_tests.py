"""Builds by clusters of worker processes: the archive is the one that a single process makes, byte for byte."""

import filecmp
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.request

import kubernetes_validate
import yaml
from dask.distributed import Client, LocalCluster

import terrain_dask

HERE = pathlib.Path(__file__).parent
TOP = HERE.parent.parent
PROGRAM = os.environ.get("TERRAIN_INGEST", str(TOP / "target/debug/terrain-ingest"))
SAMPLE = str(TOP / "data-samples/jacksboro_fault.tif")
OPTIONS = ["--max-error", "10", "--leaves", "4"]


class Clusters(unittest.TestCase):
    """Worker processes on this machine."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.one = str(cls.folder / "one.pmtiles")
        terrain_dask.terrain_ingest(PROGRAM, SAMPLE, "--max-error", "10", "-o", cls.one)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def build(self, client, work, name):
        """An archive by a cluster; whether it is the one of a single process."""
        output = str(self.folder / name)
        terrain_dask.build(client, [SAMPLE], work, output, PROGRAM, OPTIONS)
        return filecmp.cmp(self.one, output, shallow=False)

    def test_a_worker_that_is_killed_costs_its_job_only(self):
        with LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            killed = []

            def kill():
                while not self.has_tiles("killed"):
                    time.sleep(0.01)
                pid = next(iter(client.run(os.getpid).values()))
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)

            killer = threading.Thread(target=kill, daemon=True)
            killer.start()
            self.assertTrue(self.build(client, str(self.folder / "killed"), "killed.pmtiles"))
            killer.join(timeout=10)
            self.assertEqual(len(killed), 1)

    def has_tiles(self, work):
        """Whether the stage of tiles has begun."""
        return any((self.folder / work / "tiles").glob("*"))

    def test_a_job_that_fails_says_why(self):
        with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            with self.assertRaisesRegex(terrain_dask.JobFailed, "nothing.tif: cannot be read"):
                terrain_dask.build(client, ["nothing.tif"], str(self.folder / "no"), "no.pmtiles", PROGRAM, OPTIONS)
            stage = {"stage": "top", "jobs": 1}
            terrain_dask.terrain_ingest(PROGRAM, "plan", SAMPLE, "--work", str(self.folder / "early"))
            with self.assertRaisesRegex(terrain_dask.JobFailed, "samples"):
                terrain_dask.run_stage(client, stage, PROGRAM, str(self.folder / "early"), 0, print)

    def test_a_bucket_is_as_good_a_store_as_a_folder(self):
        with Bucket() as bucket:
            with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
                self.assertTrue(self.build(client, bucket.address + "/work", "bucket.pmtiles"))


class Bucket:
    """An S3 server on this machine, in memory, with one bucket."""

    def __init__(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = "s3://terrain"

    def __enter__(self):
        endpoint = f"http://127.0.0.1:{self.port}"
        command = [sys.executable, "-m", "moto.server", "--port", str(self.port)]
        self.server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.environ.update(
            AWS_ENDPOINT=endpoint,
            AWS_ALLOW_HTTP="true",
            AWS_ACCESS_KEY_ID="test",
            AWS_SECRET_ACCESS_KEY="test",
            AWS_REGION="us-east-1",
        )
        request = urllib.request.Request(f"{endpoint}/terrain", method="PUT")
        for _ in range(300):
            try:
                urllib.request.urlopen(request).close()
                return self
            except OSError:
                time.sleep(0.1)
        raise RuntimeError("the S3 server did not start")

    def __exit__(self, *_):
        self.server.kill()
        self.server.wait()


class Recipes(unittest.TestCase):
    """What other schedulers are given."""

    def test_the_kubernetes_job_is_valid(self):
        text = (HERE / "kubernetes.yaml").read_text().replace("${STAGE}", "tiles").replace("${JOBS}", "12")
        job = yaml.safe_load(text)
        kubernetes_validate.validate(job, "1.33", strict=True)
        self.assertEqual(job["spec"]["completions"], 12)
        self.assertNotIn("$" + "{", text)

    def test_slurm_gets_an_array_a_stage_each_after_the_one_before(self):
        with tempfile.TemporaryDirectory() as folder:
            sbatch = pathlib.Path(folder) / "sbatch"
            sbatch.write_text('#!/bin/sh\necho "$@" >> "$ASKED"\nwc -l < "$ASKED" | tr -d " "\n')
            sbatch.chmod(0o755)
            asked = pathlib.Path(folder) / "asked"
            path = f"{folder}:{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"
            environment = {**os.environ, "PATH": path, "ASKED": str(asked)}
            command = [HERE / "slurm.sh", str(pathlib.Path(folder) / "work"), "out.pmtiles", SAMPLE, *OPTIONS]
            subprocess.run(command, env=environment, check=True, capture_output=True)
            lines = asked.read_text().splitlines()
        self.assertEqual(len(lines), 6)
        self.assertIn("--array=0-", lines[0])
        self.assertNotIn("--dependency", lines[0])
        for number, line in enumerate(lines[1:], start=1):
            self.assertIn(f"--dependency=afterok:{number}", line)
        self.assertIn("merge", lines[5])


if __name__ == "__main__":
    unittest.main()
