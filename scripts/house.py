"""What the checks of the house share: the root, and the list of exceptions that are still allowed."""
import dataclasses
import pathlib

EXCEPTIONS = "scripts/house_exceptions.txt"


@dataclasses.dataclass
class Violation:
    key: str         # what an exception names
    text: str        # what is printed
    size: int = 0    # an exception with a number allows as much


def root_of(arguments):
    """The folder named on the command line, or the repository of this script."""
    named = [a for a in arguments if not a.startswith("-")]
    return pathlib.Path(named[0]).resolve() if named else pathlib.Path(__file__).resolve().parent.parent


def read_exceptions(root, check):
    """{key: number or None} of one check. A line is "check: key" or "check: key = number"; # begins a comment line."""
    path = root / EXCEPTIONS
    listed = {}
    for line in path.read_text(encoding="utf-8").split("\n") if path.exists() else ():
        if line.startswith(f"{check}: "):
            key, _, number = line[len(check) + 2 :].partition(" = ")
            listed[key.strip()] = int(number) if number else None
    return listed


def settle(check, root, found, praise):
    """Prints what no exception allows, and exceptions that nothing needs any more; the exit status of the check."""
    listed = read_exceptions(root, check)
    bad = [v for v in found if v.key not in listed or (listed[v.key] is not None and v.size > listed[v.key])]
    idle = sorted(listed.keys() - {v.key for v in found})
    for violation in bad:
        print(violation.text)
    for key in idle:
        print(f"{EXCEPTIONS}: take out '{check}: {key}': it is in order now")
    if not bad and not idle:
        print(f"{check}: {praise}" + (f" ({len(listed)} exceptions are left)" if listed else ""))
    return 1 if bad or idle else 0


def as_exceptions(check, found):
    """The lines that would allow all that was found."""
    return [f"{check}: {v.key}" + (f" = {v.size}" if v.size else "") for v in found]
