#!/usr/bin/env python3
"""The same items through the engines that clusters have: the same merged library, byte for byte.

usage: engines_test.py PROGRAM [ITEMS [KILLS]]     ITEMS: default 300; KILLS of Slurm's node daemon: default 20
What is not installed is skipped, visibly.
"""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import slurm
from support import PROGRAM, BatchTest, digests, ellipsoids, run, take_number

ITEMS = take_number(300)
KILLS = take_number(20)
SEED = random.randrange(1 << 32)
EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "batch"
SHARDS = 6


class Engines(BatchTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.base = pathlib.Path(folder.name)
        os.chmod(cls.base, 0o755)
        cls.meshes, cls.few = cls.base / "meshes", cls.base / "few"
        ellipsoids(cls.meshes, ITEMS, rings=3, sides=4)
        ellipsoids(cls.few, 24, rings=3, sides=4)
        cls.merged = {meshes: cls.baked(meshes) for meshes in (cls.meshes, cls.few)}

    @classmethod
    def baked(cls, meshes):
        """Digests of the library that no engine has had a part in."""
        library = cls.base / f"direct-{meshes.name}"
        for arguments in ((meshes, "-o", library), ("merge", library)):
            done = run("batch", *arguments)
            assert done.returncode == 0, done.stderr
        return digests(library / "library")

    def need(self, *programs):
        absent = [p for p in programs if shutil.which(p) is None]
        if absent:
            self.skipTest(f"there is no {', '.join(absent)}")

    def execute(self, *command):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env={**os.environ, "SQMAP": PROGRAM})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def assert_same(self, output, meshes=None, message=None):
        self.bake("merge", output)
        self.assertEqual(digests(pathlib.Path(output) / "library"), self.merged[meshes or self.meshes], message)
        self.assert_whole(output)

    def test_parallel(self):
        self.need("parallel")
        self.execute("parallel", "-j2", "--halt", "soon,fail=1", PROGRAM, "batch", self.meshes, "-o", "out", "--shard", f"{{}}/{SHARDS}",
                     "--jobs", "1", ":::", *range(SHARDS))
        self.assert_same("out")

    def test_dask(self):
        if subprocess.run(["/usr/bin/python3", "-c", "import distributed"], capture_output=True).returncode != 0:
            self.skipTest("there is no Dask (Debian: python3-distributed)")
        self.execute("/usr/bin/python3", EXAMPLES / "dask_shards.py", self.meshes, "out", SHARDS)
        self.assert_same("out")

    def test_snakemake(self):
        self.need("snakemake")
        self.execute("snakemake", "--snakefile", EXAMPLES / "Snakefile", "--cores", "2", "--config", f"manifest={self.meshes}",
                     "out=out", f"shards={SHARDS}")
        self.assert_same("out")

    def test_slurm_array(self):
        with self.slurm() as cluster:
            self.submit(cluster, "array", self.meshes)
            self.assert_same("array")

    def test_parallel_inside_a_slurm_job(self):
        self.need("parallel")
        with self.slurm() as cluster:
            export = f"ALL,SQMAP={PROGRAM},MANIFEST={self.meshes},OUT={os.path.abspath('step')},SHARDS={SHARDS}"
            done = cluster.submit(f"--export={export}", EXAMPLES / "slurm_parallel.sh")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr + cluster.logs())
            self.assert_same("step")

    def test_the_node_daemon_is_killed(self):
        """Alone, or with all that it runs as when a machine goes down; Slurm finds out, the array is submitted again."""
        chance = random.Random(SEED)
        with self.slurm() as cluster:
            start = time.monotonic()
            self.submit(cluster, "whole", self.few)
            length = time.monotonic() - start
            for k in range(KILLS):
                output = f"dead{k}"
                self.submit(cluster, output, self.few, wait=False)
                time.sleep(chance.uniform(0, length))
                if chance.random() < 0.5:
                    self.end_steps()
                cluster.stop("slurmd", signal.SIGKILL)
                cluster.start_node()
                cluster.run("scancel", "--me")
                cluster.wait_for(cluster.is_idle, "the node")
                self.submit(cluster, output, self.few)
                self.assert_same(output, self.few, f"seed {SEED}, kill {k}")

    def slurm(self):
        if slurm.missing():
            self.skipTest(slurm.missing())
        folder = tempfile.TemporaryDirectory(dir=self.base)
        self.addCleanup(folder.cleanup)
        return slurm.Slurm(pathlib.Path(folder.name) / "slurm")

    def submit(self, cluster, output, meshes, **how):
        export = f"ALL,SQMAP={PROGRAM},MANIFEST={meshes},OUT={os.path.abspath(output)}"
        done = cluster.submit(f"--array=0-{SHARDS - 1}", f"--export={export}", EXAMPLES / "slurm.sh", **how)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr + cluster.logs())

    def end_steps(self):
        """Ends slurmstepd and what it has started: they would outlive slurmd. Those of this test's own folder only."""
        mark = str(self.base).encode()
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                is_step = (process / "comm").read_text().startswith("slurmstepd") and mark in (process / "environ").read_bytes()
                is_driver = mark in (process / "cmdline").read_bytes() and (process / "comm").read_text().strip() == "sqmap"
                if is_step or is_driver:
                    os.kill(int(process.name), signal.SIGKILL)
            except (OSError, ProcessLookupError):
                pass


if __name__ == "__main__":
    unittest.main()
