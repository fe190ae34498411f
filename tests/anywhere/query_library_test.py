"""libsqmap_query is small, exports what libsqmap does but baking, answers with the same bits, and refuses paper models."""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

MAX_BYTES = 1_400_000  # stripped
BAKING = {"sqmap_bake", "sqmap_bake_file", "sqmap_option_range", "sqmap_export"}

parser = argparse.ArgumentParser(description=__doc__)
for option in ("--program", "--whole", "--query"):
    parser.add_argument(option, required=True)
parser.add_argument("--answers", required=True, nargs=2, help="programs linked to the whole and to the queries' library")
arguments = parser.parse_args()
problems = []


def output(*command):
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    return done.returncode, done.stdout + done.stderr


def exported(library):
    return set(re.findall(r" T (sqmap_\w+)", output("nm", "-D", "--defined-only", library)[1]))


with tempfile.TemporaryDirectory() as folder:
    stripped = pathlib.Path(folder, "stripped.so")
    subprocess.run(["strip", "-o", stripped, arguments.query], check=True)
    size = stripped.stat().st_size
    print(f"libsqmap_query: {size} bytes stripped")
    if size > MAX_BYTES:
        problems.append(f"more than {MAX_BYTES} bytes: look at 'nm -S --size-sort' of both")

    if exported(arguments.whole) - exported(arguments.query) != BAKING or exported(arguments.query) - exported(arguments.whole):
        problems.append("its functions are not those of libsqmap but baking")

    torus, model, normal = (str(pathlib.Path(folder, name)) for name in ("torus.obj", "torus.sqmap", "normal.sqmap"))
    for command in (["shapes", "torus", "-o", torus], ["bake", torus, "-o", model],
                    ["bake", torus, "--projection", "normal", "-o", normal]):
        subprocess.run([arguments.program, *command], check=True, stdout=subprocess.DEVNULL)
    whole, query = (output(program, model) for program in arguments.answers)
    if whole[0] != 0 or whole != query:
        problems.append(f"other answers than libsqmap's:\n{whole[1]}\n{query[1]}")
    code, said = output(arguments.answers[1], normal)
    if code == 0 or "paper model" not in said:
        problems.append(f"a paper model was not refused: {code} {said}")

print("\n".join(problems))
sys.exit(1 if problems else 0)
