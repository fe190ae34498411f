#!/usr/bin/env python3
"""Processes that are killed at any moment, and full disks: run again, the shards are those of an undisturbed run.

usage: kills_test.py PROGRAM [KILLS]     KILLS: of workers and of the driver, each; default 2
"""
import os
import pathlib
import random
import signal
import subprocess
import tempfile
import time
import unittest

from support import COARSE, PROGRAM, BatchTest, children, digests, ellipsoids, run, take_number

KILLS = take_number(2)
SEED = random.randrange(1 << 32)


class Kills(BatchTest):
    COUNT = 5

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.meshes, whole = pathlib.Path(folder.name, "meshes"), pathlib.Path(folder.name, "whole")
        ellipsoids(cls.meshes, cls.COUNT)
        (cls.meshes / "bad.off").write_text("no mesh")
        start = time.monotonic()
        assert run("batch", cls.meshes, "-o", whole, "--jobs", "2", *COARSE).returncode == 0
        cls.length = time.monotonic() - start
        cls.whole = digests(whole / "shards")
        cls.size = (whole / "shards" / "00000-of-00001.tar").stat().st_size

    def start(self, output):
        return subprocess.Popen([PROGRAM, "batch", self.meshes, "-o", output, "--jobs", "2", "--progress", "none", *COARSE])

    def assert_nothing_partial(self, output):
        """Every file that can be read while nothing runs is whole."""
        if list(pathlib.Path(output).glob("shards/*.tar")):
            checked = run("batch", "verify", output)
            self.assertEqual(checked.returncode, 0, checked.stderr)
        for journal in pathlib.Path(output).glob("running/*.part"):
            self.assertNotEqual(run("info", journal).returncode, 0)
            self.assertNotEqual(run("batch", "verify", journal).returncode, 0)

    def test_the_driver_is_killed(self):
        chance = random.Random(SEED)
        for k in range(KILLS):
            output = f"driver{k}"
            process = self.start(output)
            time.sleep(chance.uniform(0, self.length))
            workers = children(process.pid)
            process.kill()
            process.wait()
            deadline = time.monotonic() + 10
            while any(os.path.exists(f"/proc/{w}") for w in workers) and time.monotonic() < deadline:
                time.sleep(0.01)
            self.assertFalse([w for w in workers if os.path.exists(f"/proc/{w}")], "a worker outlived its driver")
            self.assert_nothing_partial(output)
            self.bake(self.meshes, "-o", output)
            self.assertEqual(digests(f"{output}/shards"), self.whole, f"seed {SEED}, kill {k}")
            self.assert_whole(output)

    def test_workers_are_killed(self):
        chance = random.Random(SEED)
        process, killed = self.start("workers"), 0
        while process.poll() is None and killed < KILLS:
            time.sleep(chance.uniform(0, self.length / KILLS))
            for worker in children(process.pid)[:1]:
                try:
                    os.kill(worker, signal.SIGKILL)
                    killed += 1
                except ProcessLookupError:
                    pass
        self.assertEqual(process.wait(), 0)
        self.assertGreater(killed, 0)
        self.bake(self.meshes, "-o", "workers")
        self.assertEqual(digests("workers/shards"), self.whole, f"seed {SEED}")

    def test_a_torn_or_flipped_record_is_baked_again(self):
        process = self.start("torn")
        journal = pathlib.Path("torn/running/00000-of-00001.part")
        while not (journal.exists() and journal.stat().st_size > 0.6 * self.size) and process.poll() is None:
            time.sleep(0.02)
        process.kill()
        process.wait()
        data = bytearray(journal.read_bytes())
        self.assertGreater(len(data), 0.6 * self.size)
        for change in (data[:-1000], data[:100_000] + b"\0" * 5000 + data[105_000:], data + b"sqmap-result half", b"\0" * 4096):
            journal.parent.mkdir(exist_ok=True)
            pathlib.Path("torn/shards/00000-of-00001.tar").unlink(missing_ok=True)
            journal.write_bytes(change)
            self.bake(self.meshes, "-o", "torn")
            self.assertEqual(digests("torn/shards"), self.whole)

    def test_a_full_disk_ends_the_run_and_keeps_what_is_finished(self):
        """Among the results, and while the shard is written."""
        for share in (0.3, 1.2):  # of the shard, which is about as large as its results
            os.mkdir("disk")
            size = f"size={int(share * self.size)}"
            if subprocess.run(["mount", "-t", "tmpfs", "-o", size, "tmpfs", "disk"], capture_output=True).returncode != 0:
                self.skipTest("a small file system cannot be mounted here")
            try:
                self.fill_disk()
            finally:
                subprocess.run(["umount", "disk"], check=True)
                os.rmdir("disk")

    def fill_disk(self):
        full = self.bake(self.meshes, "-o", "disk/out", code=2)
        self.assertIn("No space left on device", full.stderr)
        self.assertIn("run the same command again", full.stderr)
        self.assert_nothing_partial("disk/out")
        subprocess.run(["mount", "-o", "remount,size=64m", "disk"], check=True)
        again = self.bake(self.meshes, "-o", "disk/out", "--progress", "json")
        self.assertIn('"seconds":0.000', again.stdout)
        self.assertEqual(digests("disk/out/shards"), self.whole)
        self.assert_whole("disk/out")

    def test_one_process_at_a_time_has_a_shard(self):
        process = self.start("twice")
        journal = pathlib.Path("twice/running/00000-of-00001.part")
        while not journal.exists() and process.poll() is None:
            time.sleep(0.01)
        second = self.bake(self.meshes, "-o", "twice", code=2)
        self.assertIn("another process works on this shard", second.stderr)
        self.assertEqual(process.wait(), 0)
        self.assertEqual(digests("twice/shards"), self.whole)


if __name__ == "__main__":
    unittest.main()
