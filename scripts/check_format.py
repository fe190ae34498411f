#!/usr/bin/env python3
"""Checks, or with --fix makes, the format of all C++ sources with clang-format 14, the one of Debian 12.

usage: check_format.py [ROOT] [--fix]     exit 0 when all are formatted, 77 where there is no clang-format 14
"""
import concurrent.futures
import os
import shutil
import subprocess
import sys

import cpp_source
import house

FOLDERS = ("include", "src", "apps", "bench", "examples", "tests")


def formatter():
    """clang-format of version 14; others format otherwise."""
    for name in ("clang-format-14", "clang-format"):
        if shutil.which(name) and " 14." in subprocess.run([name, "--version"], capture_output=True, text=True).stdout:
            return name
    return None


def main():
    root = house.root_of(sys.argv[1:])
    program = formatter()
    if program is None:
        print("skipped: there is no clang-format 14 (Debian: clang-format-14)")
        return 77
    files = [str(p) for p in cpp_source.sources(root, *FOLDERS)]
    how = ["-i"] if "--fix" in sys.argv else ["--dry-run", "-Werror"]
    jobs = os.cpu_count() or 1
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        bad = [d for d in pool.map(lambda some: subprocess.run([program, *how, *some]).returncode, [files[i::jobs] for i in range(jobs)]) if d]
    if not bad:
        print(f"format: {len(files)} files")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
