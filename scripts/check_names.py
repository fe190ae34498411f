#!/usr/bin/env python3
"""Runs clang-tidy (14 or later), with the checks of .clang-tidy, over the C++ sources in the build folder of the preset dev.

A source in which nothing was found is not looked at again until it, a file of the project that it includes, its compiler's
command or the rules have changed.
usage: check_names.py [ROOT] [FILE...]     FILE: relative to ROOT; without any, all sources of src, apps, bench and examples
exit 0 when nothing is found, 77 where there is no clang-tidy
"""
import collections
import concurrent.futures
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

import check_layers
import house

CLEAN = "build/dev/names_clean.json"  # {file: key of the state in which nothing was found}
FOLDERS = ("src/", "apps/", "bench/", "examples/")


def tidy():
    """The oldest clang-tidy from 14 on, the names of whose checks are those that .clang-tidy was written for: (name, version)."""
    for name in ["clang-tidy-14", *(f"clang-tidy-{n}" for n in range(15, 30)), "clang-tidy"]:
        if shutil.which(name):
            version = re.search(r"version (\d+)\S*", subprocess.run([name, "--version"], capture_output=True, text=True).stdout)
            if version and int(version.group(1)) >= 14:
                return name, version.group(0)
    return None, None


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")


def keys_of(root, commands, version):
    """{file: hash of all that its check depends on}."""
    tree = check_layers.Tree(root)
    included = collections.defaultdict(set)
    for name, target in tree.edges:
        included[name].add(target)
    digests = {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in tree.files.items()}
    rules = [version] + [(root / name).read_text(encoding="utf-8") for name in (".clang-tidy", "src/model/sqmap.fbs")]
    return {file: hashlib.sha256("\n".join([*rules, commands[file], *(f"{n} {digests[n]}" for n in
                                             sorted(check_layers.closure(file, included)) if n in digests)]).encode()).hexdigest()
            for file in commands}


def main():
    named = [a for a in sys.argv[1:] if not a.startswith("-")]
    root, wanted = house.root_of(named[:1]), named[1:]
    program, version = tidy()
    if program is None:
        print("skipped: there is no clang-tidy of version 14 or later (Debian: clang-tidy-14)")
        return 77
    os.chdir(root)
    run("cmake", "--preset", "dev")
    run("cmake", "--build", "build/dev", "--target", "sqmap_schema")
    with open("build/dev/compile_commands.json", encoding="utf-8") as commands:
        compiled = {os.path.relpath(c["file"], root): c["command"] for c in json.load(commands)}
    files = sorted(f for f in compiled if f.startswith(FOLDERS) and (not wanted or f in wanted))
    keys = keys_of(root, {f: compiled[f] for f in files}, version)
    clean = {}
    if os.path.exists(CLEAN):
        with open(CLEAN, encoding="utf-8") as known:
            clean = json.load(known)
    changed = [f for f in files if clean.get(f) != keys[f]]

    def checked(file):
        done = subprocess.run([program, "-p", "build/dev", "--quiet", "--extra-arg=-Wno-unknown-warning-option", file],
                              capture_output=True, text=True)
        return (done.returncode, file, done.stdout + (done.stderr if done.returncode and "error:" not in done.stdout else ""))

    jobs = int(os.environ.get("SQMAP_JOBS", os.cpu_count() or 1))
    bad = 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for status, file, words in pool.map(checked, changed):
            if status != 0:
                bad += 1
                print(f"{file}\n{words}", flush=True)
                continue
            clean[file] = keys[file]
            with open(CLEAN, "w", encoding="utf-8") as known:
                json.dump(clean, known)
    print(f"names: {len(files)} files, {len(changed)} of them changed, {bad} with errors")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
