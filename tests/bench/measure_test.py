#!/usr/bin/env python3
"""Tests that the table of measurements says where it comes from."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import measure


class Commit(unittest.TestCase):
    def test_it_says_whether_sources_differ_from_it(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)

            def git(*arguments):
                subprocess.run(["git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@example.org", *arguments], check=True,
                               capture_output=True)

            git("init")
            self.assertEqual(measure.commit(folder), "unknown")
            (root / "docs").mkdir()
            for name in ("code.cpp", "README.md", "docs/page.md", "docs/picture.svg"):
                (root / name).write_text("a")
            git("add", ".")
            git("commit", "-m", "First")
            clean = measure.commit(folder)
            self.assertRegex(clean, "^[0-9a-f]{7,}$")
            # Files that a run writes or that git does not know do not change the program.
            (root / "docs/page.md").write_text("b")
            (root / "docs/picture.svg").write_text("b")
            (root / "README.md").write_text("b")
            (root / "new.cpp").write_text("b")
            self.assertEqual(measure.commit(folder), clean)
            (root / "code.cpp").write_text("b")
            self.assertEqual(measure.commit(folder), clean + "-dirty")


if __name__ == "__main__":
    unittest.main()
