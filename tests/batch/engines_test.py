#!/usr/bin/env python3
"""The same items through the engines that clusters have: the same merged library, byte for byte.

usage: engines_test.py PROGRAM [ITEMS]     ITEMS: default 300; what is not installed is skipped, visibly
"""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import slurm
from support import PROGRAM, BatchTest, digests, ellipsoids, run

ITEMS = int(sys.argv.pop(1)) if len(sys.argv) > 1 and sys.argv[1].isdigit() else 300
EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "batch"
SHARDS = 6


class Engines(BatchTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.base = pathlib.Path(folder.name)
        os.chmod(cls.base, 0o755)
        cls.meshes = cls.base / "meshes"
        ellipsoids(cls.meshes, ITEMS, rings=6, sides=8)
        for program in (("batch", cls.meshes, "-o", cls.base / "direct"), ("batch", "merge", cls.base / "direct")):
            done = run(*program)
            assert done.returncode == 0, done.stderr
        cls.direct = digests(cls.base / "direct" / "library")

    def need(self, *programs):
        absent = [p for p in programs if shutil.which(p) is None]
        if absent:
            self.skipTest(f"there is no {', '.join(absent)}")

    def execute(self, *command):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env={**os.environ, "SQMAP": PROGRAM})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def assert_same(self, output):
        self.bake("merge", output)
        self.assertEqual(digests(pathlib.Path(output) / "library"), self.direct)
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

    def test_slurm_array_parallel_step_and_a_dead_node_daemon(self):
        if slurm.missing():
            self.skipTest(slurm.missing())
        with slurm.Slurm(self.base / "slurm") as cluster:
            export = f"ALL,SQMAP={PROGRAM},MANIFEST={self.meshes},OUT={os.path.abspath('array')}"
            done = cluster.submit(f"--array=0-{SHARDS - 1}", f"--export={export}", EXAMPLES / "slurm.sh")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr + self.logs())
            self.assert_same("array")

            if shutil.which("parallel"):
                export = f"ALL,SQMAP={PROGRAM},MANIFEST={self.meshes},OUT={os.path.abspath('step')},SHARDS={SHARDS}"
                done = cluster.submit(f"--export={export}", EXAMPLES / "slurm_parallel.sh")
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr + self.logs())
                self.assert_same("step")

            self.kill_node_daemon(cluster)

    def kill_node_daemon(self, cluster):
        """With all that it runs, as when a machine goes down; Slurm finds out, the array is submitted again."""
        export = f"ALL,SQMAP={PROGRAM},MANIFEST={self.meshes},OUT={os.path.abspath('dead')}"
        array = (f"--array=0-{SHARDS - 1}", f"--export={export}", "--output", cluster.folder / "job-%A_%a.out", EXAMPLES / "slurm.sh")
        cluster.run("sbatch", *array)
        journals = pathlib.Path("dead/running")
        deadline = time.monotonic() + 120
        while not any(p.stat().st_size > 0 for p in journals.glob("*.part")) and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(random.uniform(0, 2))
        self.end_steps()
        cluster.stop("slurmd", signal.SIGKILL)
        cluster.run("scancel", "--me")
        cluster.start_node()
        cluster.wait_for(cluster.is_idle, "the node")
        done = cluster.submit(f"--array=0-{SHARDS - 1}", f"--export={export}", EXAMPLES / "slurm.sh")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr + self.logs())
        self.assert_same("dead")

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

    def logs(self):
        return "".join(f"\n{p.name}: {p.read_text(errors='replace')[-500:]}" for p in (self.base / "slurm").glob("*.out"))


if __name__ == "__main__":
    unittest.main()
