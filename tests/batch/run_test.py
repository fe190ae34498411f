#!/usr/bin/env python3
"""Libraries of models as a user makes them: manifests, shards, keys, archives.

usage: run_test.py PROGRAM
"""
import io
import json
import os
import pathlib
import shutil
import subprocess
import tarfile
import unittest
import zipfile

from support import BAKED, COARSE, PROGRAM, BatchTest, digests, ellipsoid, ellipsoids, rows, run


class Manifests(BatchTest):
    def setUp(self):
        super().setUp()
        ellipsoids("meshes", 2)

    def test_every_kind_of_manifest_names_the_same_meshes(self):
        pathlib.Path("a.csv").write_text('id,path\n1,"meshes/0000.off"\n2,meshes/0001.off\n')
        pathlib.Path("b.csv").write_text("meshes/0000.off\r\nmeshes/0001.off\r\n")
        pathlib.Path("c.jsonl").write_text('{"path": "meshes/0000.off"}\n\n{"path": "meshes/0001.off", "id": 7}\n')
        pathlib.Path("d.txt").write_text("\ufeffmeshes/0000.off\nmeshes/0001.off")
        keys = set()
        for manifest in ("a.csv", "b.csv", "c.jsonl", "d.txt", "meshes"):
            self.bake(manifest, "-o", "out-" + manifest)
            found = rows("out-" + manifest)
            self.assertEqual(sorted(os.path.basename(path) for path in found), ["0000.off", "0001.off"])
            keys.add(tuple(sorted(row["key"] for row in found.values())))
        self.assertEqual(len(keys), 1)

    def test_a_wrong_line_is_a_row_that_names_it(self):
        text = b'path,member\nmeshes/0000.off\nmeshes/absent.off\nmeshes/0000.off\n,\nmeshes\nbad\xff.off\n/dev/zero'
        pathlib.Path("m.csv").write_bytes(text)
        shutil.copy("meshes/0001.off", b"bad\xff.off")
        self.bake("m.csv", "-o", "out")
        listed = [json.loads(line) for line in run("batch", "list", "out", "--json").stdout.splitlines()]
        by_line = {row["line"]: row for row in listed}
        self.assertEqual(by_line[2]["verdict"], "accept")
        self.assertEqual((by_line[3]["verdict"], by_line[3]["code"]), ("unreadable", "E_FILE"))
        self.assertEqual((by_line[4]["verdict"], by_line[4]["reason"]), ("duplicate", "it repeats line 2"))
        self.assertEqual(by_line[5]["element"], "line 5")
        self.assertEqual(by_line[6]["reason"], "it is not a file")
        self.assertEqual((by_line[7]["verdict"], by_line[7]["path_hex"]), ("accept", b"bad\xff.off".hex()))
        self.assertEqual(by_line[8]["reason"], "it is not a file")
        pathlib.Path("m.jsonl").write_bytes(b'{"path": "meshes/0000.off"}\n{"path": "\xff"}\n{"path": 3}\n[]\n')
        self.bake("m.jsonl", "-o", "out2")
        listed = [json.loads(line) for line in run("batch", "list", "out2", "--json").stdout.splitlines()]
        self.assertEqual(sorted((row["line"], row["verdict"]) for row in listed),
                         [(1, "accept"), (2, "unreadable"), (3, "unreadable"), (4, "unreadable")])

    def test_the_log_names_lines_and_escapes_control_characters(self):
        pathlib.Path("m.csv").write_bytes(b'path\nmeshes/0000.off\n\xc2\x9b31m\x1b[2J.off\n,\n"two\nlines.off"\n')
        log = self.bake("m.csv", "-o", "out").stderr
        listed = run("batch", "list", "out").stdout
        for text in (log, listed):
            self.assertIn(r"\u009b31m\x1b[2J.off  [line 3]: ", text)
            self.assertIn("[line 4]: it names no path", text)
            self.assertIn(r"two\x0alines.off  [line 5]: ", text)
            self.assertFalse([c for c in text if (c < " " and c != "\n") or "\x7f" <= c < "\xa0"])
        self.assertEqual(len(listed.splitlines()), 4)

    def test_failures_of_equal_content_are_all_in_the_log(self):
        for name in ("a", "b", "c"):
            pathlib.Path(f"meshes/{name}.off").write_text("OFF\n")
        log = self.bake("meshes", "-o", "out", "--jobs", "2").stderr
        for name in ("a", "b", "c"):
            self.assertRegex(log, rf"refused +{name}\.off: ")
        self.assertNotIn("a.off", self.bake("meshes", "-o", "out").stderr)

    def test_a_manifest_without_meshes_ends_the_run(self):
        os.mkdir("empty")
        pathlib.Path("heading.csv").write_text("path,member\n")
        pathlib.Path("empty.txt").write_text("\n")
        for manifest in ("empty", "heading.csv", "empty.txt"):
            said = self.bake(manifest, "-o", "out", code=2).stderr
            self.assertIn(f"{manifest}: it names no mesh", said)
            self.assertIn("cure: ", said)
        self.assertFalse(os.path.exists("out"))

    def test_what_a_folder_hides_is_a_row(self):
        os.mkdir("linked")
        os.symlink("../meshes", "linked/there")
        os.symlink("nowhere", "linked/broken.off")
        os.symlink("../out", "linked/library")
        log = self.bake("linked", "-o", "out").stderr
        self.assertIn("there: it is a link to a folder, which is not followed", log)
        self.bake("linked", "-o", "out")
        self.assertEqual({path: row["code"] for path, row in rows("out").items()}, {"broken.off": "E_FILE", "there": "E_FOLDER"})
        if os.geteuid() == 0:
            return  # who may read everything
        os.mkdir("linked/closed", 0)
        self.bake("linked", "-o", "out2")
        self.assertEqual(rows("out2")["closed"]["reason"], "Permission denied")

    def test_a_mesh_or_an_archive_is_a_manifest(self):
        with tarfile.open("two.tar", "w") as archive:
            archive.add("meshes")
        self.bake("two.tar", "-o", "out")
        self.bake("meshes/0000.off", "-o", "out2")
        self.assertEqual(set(rows("out")), {"two.tar/meshes/0000.off", "two.tar/meshes/0001.off"})
        self.assertEqual(rows("out")["two.tar/meshes/0000.off"]["key"], rows("out2")["0000.off"]["key"])

    def test_what_would_swallow_or_shift_items_ends_the_run(self):
        pathlib.Path("q.csv").write_text('path\nmeshes/0000.off\n"meshes/open\nmeshes/0001.off\n')
        self.assertIn("q.csv, line 3: a quote has no end", self.bake("q.csv", "-o", "out", code=2).stderr)
        self.assertIn("name another folder", self.bake("meshes", "-o", "meshes", code=2).stderr)
        self.assertEqual(sorted(os.listdir("meshes")), ["0000.off", "0001.off"])

    def test_wrong_usage_is_64_and_a_missing_manifest_is_2(self):
        for arguments in ([], ["meshes"], ["meshes", "-o", "o", "--shard", "2/2"], ["meshes", "-o", "o", "--shard", "x"],
                          ["meshes", "-o", "o", "--shard", ""], ["meshes", "-o", "o", "--rank", "1"], ["meshes", "-o", "o", "--time", "0"], ["retry", "."]):
            self.bake(*arguments, code=64)
        both = self.bake("meshes", "-o", "o", "--shard", "0/2", "--rank", "1", "--world-size", "2", code=64)
        self.assertTrue("--shard" in both.stderr and "--rank" in both.stderr, both.stderr)
        for size in ("lots", "-3", "4PB", "1025TB", "0", ""):
            said = self.bake("meshes", "-o", "o", "--memory", size, code=64).stderr
            self.assertIn(f"--memory: '{size}' is not a size", said)
            self.assertIn("4GB", said)
            self.assertLess(len(said), 250)
        for arguments in (["absent.csv", "-o", "o"], ["list", "meshes"], ["merge", "meshes"], ["verify", "meshes"]):
            self.bake(*arguments, code=2)
        self.assertFalse(os.path.exists("o"))
        self.bake("meshes", "-o", "meshes/0000.off/out", code=2)


class Keys(BatchTest):
    def test_finished_keys_are_skipped_and_shared(self):
        ellipsoids("meshes", 2)
        shutil.copy("meshes/0000.off", "meshes/same.off")
        first = self.bake("meshes", "-o", "out", "--progress", "json")
        self.assertEqual(sum(json.loads(line)["seconds"] > 0 for line in first.stdout.splitlines()), 2)
        before = os.stat("out/shards/00000-of-00001.tar")
        again = self.bake("meshes", "-o", "out", "--progress", "json")
        self.assertTrue(all(json.loads(line)["seconds"] == 0 for line in again.stdout.splitlines()))
        self.assertEqual(os.stat("out/shards/00000-of-00001.tar").st_ino, before.st_ino)
        ellipsoid("meshes/0001.off", (1, 1, 2))
        third = self.bake("meshes", "-o", "out", "--progress", "json")
        self.assertEqual([json.loads(line)["path"] for line in third.stdout.splitlines() if json.loads(line)["seconds"] > 0], ["0001.off"])
        self.assert_whole("out")
        self.bake("report", "out")
        self.assertIn('"models":2,', pathlib.Path("out/report/index.html").read_text())

    def test_buffers_beside_a_gltf_file_count(self):
        gltf = {"asset": {"version": "2.0"}, "buffers": [{"uri": "data.bin", "byteLength": 12}]}
        os.mkdir("meshes")
        keys = []
        for content in (b"\0" * 12, b"\1" * 12):
            pathlib.Path("meshes/a.gltf").write_text(json.dumps(gltf))
            pathlib.Path("meshes/data.bin").write_bytes(content)
            self.bake("meshes", "-o", "out")
            keys.append(rows("out")["a.gltf"]["key"])
        self.assertNotEqual(*keys)

    def test_other_options_need_another_folder(self):
        ellipsoids("meshes", 1)
        self.bake("meshes", "-o", "out", "--max-parts", "3")
        refused = self.bake("meshes", "-o", "out", code=2)
        self.assertIn("--max-parts=3", refused.stderr)
        self.bake("meshes", "-o", "out", "--max-parts", "3", "--jobs", "1", "--time", "20")

    def test_a_model_is_that_of_bake_without_the_name_of_its_file(self):
        ellipsoids("meshes", 1)
        self.assertEqual(run("batch", "meshes", "-o", "out").returncode, 0)
        row = rows("out")["0000.off"]
        self.bake("extract", "out", row["key"], "-o", "a.sqmap")
        self.assertEqual(run("bake", "meshes/0000.off", "-o", "b.sqmap").returncode, 0)
        info = [json.loads(run("info", name, "--json").stdout) for name in ("a.sqmap", "b.sqmap")]
        self.assertEqual((info[0].pop("source"), info[1].pop("source")), ("", "0000.off"))
        for one in info:
            del one["content_hash"], one["bytes"]  # the name is among what they count
        self.assertEqual(*info)
        self.assertNotIn(b"0000.off", pathlib.Path("a.sqmap").read_bytes())
        self.bake("extract", "out", "0" * 64, "-o", "c.sqmap", code=2)

    def test_a_model_is_extracted_by_path_name_or_first_digits(self):
        ellipsoids("meshes/deep", 2)
        shutil.copy("meshes/deep/0001.off", "meshes/0000.off")
        pathlib.Path("meshes/bad.off").write_text("OFF\n")
        with zipfile.ZipFile("meshes/a.zip", "w") as archive:
            archive.write("meshes/deep/0000.off", "in/member.off")
        self.bake("meshes", "-o", "out")
        keys = {path: row["key"] for path, row in rows("out").items()}
        named = {"deep/0000.off": "deep/0000.off", "0000.off": "0000.off", "0001.off": "0000.off",
                 keys["0000.off"][:12]: "0000.off", "a.zip/in/member.off": "deep/0000.off", "in/member.off": "deep/0000.off",
                 "member.off": "deep/0000.off"}
        for text, path in named.items():
            self.bake("extract", "out", text, "-o", "named.sqmap")
            self.bake("extract", "out", keys[path], "-o", "by_key.sqmap")
            self.assertEqual(pathlib.Path("named.sqmap").read_bytes(), pathlib.Path("by_key.sqmap").read_bytes(), text)
        os.remove("meshes/0000.off")
        ellipsoid("meshes/other/0000.off", (1, 1, 2))
        self.bake("meshes", "-o", "out")
        said = self.bake("extract", "out", "0000.off", "-o", "c.sqmap", code=2).stderr
        for path in ("deep/0000.off", "other/0000.off"):
            self.assertIn(f"{rows('out')[path]['key'][:16]}  accept     {path}", said)
        self.assertIn("refused", self.bake("extract", "out", "bad.off", "-o", "c.sqmap", code=2).stderr)
        self.assertIn("'x.off'", self.bake("extract", "out", "x.off", "-o", "c.sqmap", code=2).stderr)
        self.assertFalse(os.path.exists("c.sqmap"))


class Shards(BatchTest):
    def test_merged_shards_have_the_same_bytes_however_many_there_were(self):
        ellipsoids("meshes", 4)
        pathlib.Path("meshes/bad.off").write_text("OFX")
        shutil.copy("meshes/0003.off", "meshes/zz.off")
        merged = []
        for count in (1, 3):
            for i in range(count):
                self.bake("meshes", "-o", f"out{count}", "--shard", f"{i}/{count}")
            self.bake("merge", f"out{count}", "--size", "200kB")
            merged.append(digests(f"out{count}/library"))
            self.assert_whole(f"out{count}")
            self.assertEqual(len(rows(f"out{count}")), 6)
        self.assertGreater(len(merged[0]), 1)
        self.assertEqual(merged[0], merged[1])
        # Merged keys are known to later runs, with other shards too; then nothing is left of the shards.
        self.bake("gc", "out3")
        self.assertEqual(list(pathlib.Path("out3/shards").iterdir()), [])
        for arguments in ([], ["--shard", "1/3"]):
            again = self.bake("meshes", "-o", "out3", "--progress", "json", *arguments)
            self.assertTrue(all(json.loads(line)["seconds"] == 0 for line in again.stdout.splitlines()))
            for folder in ("shards", "running"):
                self.assertEqual(list(pathlib.Path("out3", folder).iterdir()), [])
            self.assertEqual(self.bake("list", "out3").stderr, "")
        self.bake("merge", "out3", "--size", "200kB")
        self.assertEqual(digests("out3/library"), merged[0])

    def test_a_missing_shard_is_said(self):
        for i in range(3):
            pathlib.Path(f"{i}.off").write_text("OFF\n")
        for i in (0, 2):
            self.bake(".", "-o", "out", "--shard", f"{i}/3")
        for arguments in (("list", "out"), ("verify", "out"), ("report", "out")):
            self.assertIn("1 of 3 shards is not finished: 1", self.bake(*arguments).stderr)
        self.assertIn("1 of 3 shards is not finished: 1", self.bake("merge", "out", code=2).stderr)
        self.assertEqual(digests("out/library"), {})
        self.bake("merge", "out", "--partial")
        self.bake("gc", "out")
        self.assertEqual(len(rows("out")), 2)
        self.assertIn("1 of 3 shards is not finished: 1", self.bake("list", "out").stderr)
        self.bake(".", "-o", "out", "--shard", "1/3")
        self.bake("merge", "out")
        self.bake("gc", "out")
        self.bake(".", "-o", "out", "--shard", "2/3")
        self.assertEqual(self.bake("list", "out").stderr, "")
        self.assertEqual(len(rows("out")), 3)

    def test_a_manifest_that_changes_between_shards_is_said(self):
        for i in range(5):
            pathlib.Path(f"{i}.off").write_text(f"OFF\n{i}")
        names = [f"{i}.off\n" for i in range(4)]
        shard = lambda i: self.bake("m.txt", "-o", "out", "--shard", f"{i}/2")
        manifest = pathlib.Path("m.txt")
        manifest.write_text("".join(names))
        shard(0)
        manifest.write_text("4.off\n" + "".join(names))  # now 1 and 3 would be in shard 0, which has 0 and 2
        shard(1)
        words = "1 of 2 shards is of another state of the manifest: 0"
        for arguments, code in ((("list", "out"), 0), (("report", "out"), 0), (("verify", "out"), 2), (("merge", "out"), 2),
                                (("merge", "out", "--partial"), 2)):
            said = self.bake(*arguments, code=code).stderr
            self.assertIn(words, said)
            self.assertIn("run these shards again", said)
        self.assertEqual(set(rows("out")), {"0.off", "2.off"})
        self.assertIn(words, pathlib.Path("out/report/index.html").read_text())
        shard(0)
        self.assertEqual(self.bake("list", "out").stderr, "")
        self.bake("merge", "out")
        self.assert_whole("out")
        self.assertEqual(set(rows("out")), {f"{i}.off" for i in range(5)})

    def test_items_that_leave_the_manifest_leave_the_library(self):
        ellipsoids("meshes", 3)
        for merges in (False, True):
            shutil.copy("meshes/0001.off", "meshes/leaves.off")
            ellipsoid("meshes/alone.off", (1, 1, 3))
            out = f"out{merges}"
            self.bake("meshes", "-o", out)
            if merges:
                self.bake("merge", out)
                self.bake("gc", out)
            os.remove("meshes/leaves.off")
            os.remove("meshes/alone.off")
            self.bake("meshes", "-o", out)
            self.assertEqual(set(rows(out)), {"0000.off", "0001.off", "0002.off"})
            self.bake("merge", out)
            self.bake("gc", out)
            self.assertEqual(set(rows(out)), {"0000.off", "0001.off", "0002.off"})
            self.assert_whole(out)
        self.assertEqual(digests("outFalse/library"), digests("outTrue/library"))

    def test_a_mesh_that_changes_after_the_merge_is_baked_once_and_listed_once(self):
        ellipsoids("meshes", 3)
        self.bake("meshes", "-o", "out")
        self.bake("merge", "out")
        self.bake("gc", "out")
        before = rows("out")
        ellipsoid("meshes/0001.off", (1, 1, 2))
        done = self.bake("meshes", "-o", "out", "--progress", "json")
        self.assertEqual([row["path"] for row in map(json.loads, done.stdout.splitlines()) if row["seconds"] > 0], ["0001.off"])
        for merges in (False, True):
            if merges:
                self.bake("merge", "out")
                self.bake("gc", "out")
            listed = [json.loads(line) for line in self.bake("list", "out", "--json").stdout.splitlines()]
            self.assertEqual([row["path"] for row in listed], ["0000.off", "0001.off", "0002.off"])
            self.assertEqual([row["key"] == before[row["path"]]["key"] for row in listed], [True, False, True])
            self.assert_whole("out")
        self.assertEqual(len(list(pathlib.Path("out/shards").iterdir())), 0)

    def test_items_of_a_shard_that_runs_are_listed(self):
        ellipsoids("meshes", 5)
        pathlib.Path("meshes/0000.off").write_text("OFF\n")
        driver = subprocess.Popen([PROGRAM, "batch", "meshes", "-o", "out", "--progress", "json", "--jobs", "1", *COARSE],
                                  stdout=subprocess.PIPE, text=True)
        done = [json.loads(driver.stdout.readline()) for _ in range(2)]
        driver.kill()
        driver.wait()
        driver.stdout.close()
        found = rows("out")
        for row in done:
            self.assertEqual(found[row["path"]].pop("running"), True)
            self.assertEqual(found[row["path"]], {k: v for k, v in row.items() if k not in ("done", "items")})
        listed = self.bake("list", "out")
        self.assertIn("(running)", listed.stdout)
        self.assertIn("1 of 1 shards is not finished: 0", listed.stderr)
        self.bake("meshes", "-o", "out")
        self.assertFalse([row for row in rows("out").values() if "running" in row])
        self.assert_whole("out")
        self.assertEqual(list(pathlib.Path("out/running").iterdir()), [])

    def test_retry_takes_a_manifest_of_another_name(self):
        pathlib.Path("a.off").write_text("OFF\n")
        pathlib.Path("m.txt").write_text("a.off\n")
        self.bake("m.txt", "-o", "out")
        os.rename("m.txt", "n.txt")
        self.assertIn("--manifest", self.bake("retry", "out", "--verdict", "timeout", code=2).stderr)
        self.bake("retry", "out", "--verdict", "timeout", "--manifest", "n.txt")
        self.bake("retry", "out", "--verdict", "timeout")

    def test_shards_come_from_slurm_or_ranks(self):
        ellipsoids("meshes", 3)
        slurm = {"SLURM_ARRAY_TASK_ID": "4", "SLURM_ARRAY_TASK_MIN": "3", "SLURM_ARRAY_TASK_MAX": "5", "SLURM_ARRAY_TASK_COUNT": "3"}
        done = run("batch", "meshes", "-o", "out", *COARSE, env={**os.environ, **slurm})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(rows("out")), ["0001.off"])
        self.bake("meshes", "-o", "out", "--rank", "2", "--world-size", "3")
        self.assertEqual(list(rows("out")), ["0001.off", "0002.off"])
        self.bake("meshes", "-o", "out", "--shard", "0/4", code=2)
        gaps = run("batch", "meshes", "-o", "out", *COARSE, env={**os.environ, **slurm, "SLURM_ARRAY_TASK_MAX": "9"})
        self.assertEqual(gaps.returncode, 64)

    def test_an_archive_of_paper_models_is_verified_and_extracted(self):
        ellipsoids("meshes", 1)
        self.bake("meshes", "-o", "out", "--projection", "normal")
        self.assert_whole("out")
        self.bake("extract", "out", "0000.off", "-o", "one.sqmap")
        self.assertEqual(json.loads(run("info", "one.sqmap", "--json").stdout)["projection"], "normal")

    def test_an_archive_is_a_plain_tar_file(self):
        ellipsoids("meshes", 2)
        self.bake("meshes", "-o", "out")
        with tarfile.open("out/shards/00000-of-00001.tar") as archive:
            members = archive.getmembers()
            names = [m.name for m in members]
            self.assertEqual(names[:2], ["index", "rows.jsonl"])
            self.assertEqual(names[2:], sorted(names[2:]))
            self.assertTrue(all(m.mtime == 0 and m.uid == 0 and m.offset_data % 512 == 0 for m in members))
            models = [m for m in members if m.name.endswith(".sqmap")]
            index = archive.extractfile("index").read().decode().splitlines()
            self.assertEqual([line.split()[0] + ".sqmap" for line in index], [m.name for m in models])
            self.assertEqual([int(line.split()[1]) for line in index], [m.offset_data for m in models])
            pathlib.Path("m.sqmap").write_bytes(archive.extractfile(models[0]).read())
        self.assertEqual(run("info", "m.sqmap").returncode, 0)


class Archives(BatchTest):
    def test_meshes_inside_tar_and_zip(self):
        ellipsoids("meshes", 3)
        with zipfile.ZipFile("a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.write("meshes/0000.off", "deep/0000.off")
            archive.write("meshes/0001.off", "readme.txt")
            archive.writestr("tiny.off", "OFF\n")
        pathlib.Path("tiny.off").write_text("OFF\n")
        with tarfile.open("b.tar.gz", "w:gz") as archive:
            archive.add("meshes/0001.off")
            archive.add("meshes/0002.off")
        pathlib.Path("m.jsonl").write_text('{"path": "a.zip"}\n{"path": "b.tar.gz"}\n{"path": "meshes/0000.off"}\n'
                                           '{"path": "b.tar.gz", "member": "absent.off"}\n{"path": "tiny.off"}\n')
        for jobs in ("1", "2"):
            self.bake("m.jsonl", "-o", "out" + jobs, "--jobs", jobs)
            found = rows("out" + jobs)
            self.assertEqual({p: r["verdict"] for p, r in found.items()},
                             {"a.zip/deep/0000.off": "accept", "b.tar.gz/meshes/0001.off": "accept", "b.tar.gz/meshes/0002.off": "accept",
                              "meshes/0000.off": "accept", "b.tar.gz/absent.off": "unreadable", "a.zip/tiny.off": "refused",
                              "tiny.off": "refused"})
            self.assertEqual(found["a.zip/tiny.off"]["key"], found["tiny.off"]["key"])
            self.assertEqual(found["a.zip/deep/0000.off"]["key"], found["meshes/0000.off"]["key"])

    def test_names_that_are_not_utf_8(self):
        with tarfile.open("a.tar", "w", format=tarfile.GNU_FORMAT, encoding="latin-1") as archive:
            archive.addfile(tarfile.TarInfo("b\xff.off"))
        with zipfile.ZipFile("a.zip", "w") as archive:
            archive.writestr("bX.off", "")
            archive.writestr("日本.off", "")
        pathlib.Path("a.zip").write_bytes(pathlib.Path("a.zip").read_bytes().replace(b"bX.off", b"b\xff.off"))
        pathlib.Path("m.txt").write_text("a.tar\na.zip\n")
        self.bake("m.txt", "-o", "out")
        found = [(row["path"], row.get("member_hex", row["member"])) for row in rows("out").values()]
        self.assertEqual(sorted(found), [("a.tar", "62ff2e6f6666"), ("a.zip", "62ff2e6f6666"), ("a.zip", "日本.off")])

    def test_a_hostile_archive_is_rows_and_writes_nothing(self):
        with zipfile.ZipFile("m.zip", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("../../escaped.off", "OFF\n")
            archive.writestr("/tmp/escaped.off", "OFF\n")
            archive.writestr("bomb.off", b"0" * 50_000_000)
            archive.writestr("good.txt", "no mesh")
        with tarfile.open("l.tar", "w") as archive:
            link = tarfile.TarInfo("link.off")
            link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
            archive.addfile(link)
        pathlib.Path("cut.zip").write_bytes(pathlib.Path("m.zip").read_bytes()[:200])
        pathlib.Path("none.tar").write_bytes(b"")
        pathlib.Path("m.txt").write_text("m.zip\nl.tar\ncut.zip\nnone.tar\nabsent.zip\n")
        self.bake("m.txt", "-o", "out", "--max-bytes", "1000000")
        found = rows("out")
        self.assertEqual({p: (r["verdict"], r["code"]) for p, r in found.items() if not p.startswith("cut.zip")},
                         {"m.zip/../../escaped.off": ("unreadable", "E_PATH"), "m.zip//tmp/escaped.off": ("unreadable", "E_PATH"),
                          "m.zip/bomb.off": ("unreadable", "E_LIMIT"), "l.tar/link.off": ("unreadable", "E_PATH"),
                          "none.tar": ("unreadable", "E_ARCHIVE"), "absent.zip": ("unreadable", "E_FILE")})
        self.assertTrue(any(p.startswith("cut.zip") for p in found))
        for path in ("../../escaped.off", "../escaped.off", "/tmp/escaped.off"):
            self.assertFalse(os.path.exists(path), path)
        self.assertEqual(sorted(os.listdir()), ["cut.zip", "l.tar", "m.txt", "m.zip", "none.tar", "out"])


if __name__ == "__main__":
    unittest.main()
