"""Runs a check of scripts/ on a project of a few files and says what it printed."""
import pathlib
import subprocess
import sys
import tempfile

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"


def output_of(script, files):
    """(exit status, output) of the check on a project with these files: {path: text}."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        done = subprocess.run([sys.executable, SCRIPTS / script, folder], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr


def run(script, cases, common=None):
    """cases: [(claim, {path: text}, words of the complaint, or None for none)]; exits with 1 if one fails."""
    failed = 0
    for claim, files, complaint in cases:
        code, output = output_of(script, {**(common or {}), **files})
        if code != (complaint is not None) or (complaint or "") not in output:
            failed += 1
            print(f"FAILED: {claim}\n  expected {'a complaint with ' + repr(complaint) if complaint else 'none'}, got: {output}")
    print(f"{len(cases) - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)
