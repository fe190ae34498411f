"""Reads C++ sources without a compiler: their files, their includes, and their code without comments."""
import pathlib
import re

SUFFIXES = {".h", ".cpp", ".inl"}
TOKEN = re.compile(
    r'//(?:\\\n|[^\n])*'  # a comment, with continued lines
    r'|/\*.*?\*/'
    r'|R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"'
    r'|"(?:\\.|[^"\\\n])*"'
    r"|(?<![0-9a-fA-FuUlL])'(?:\\.|[^'\\\n])*'",
    re.DOTALL)


def sources(root, *folders):
    """C++ sources below the folders of root, in order."""
    for folder in folders:
        yield from sorted(p for p in (root / folder).rglob("*") if p.suffix in SUFFIXES and "node_modules" not in p.parts)


def _blank(text):
    return re.sub(r"[^\n]", " ", text)


def code_of(text):
    """The text with comments, strings and preprocessor lines blanked; offsets and lines stay."""
    def replaced(match):
        token = match.group(0)
        return '"' + _blank(token[1:-1]) + '"' if token[0] == '"' else _blank(token)

    text = TOKEN.sub(replaced, text)
    return re.sub(r"^[ \t]*#(?:\\\n|[^\n])*", lambda m: _blank(m.group(0)), text, flags=re.MULTILINE)


def includes(text):
    """(line, file) of each #include outside comments."""
    for number, line in enumerate(text.split("\n"), 1):
        match = re.match(r'\s*#\s*include\s*[<"]([^">]+)[">]', line)
        if match:
            yield number, match.group(1)


def root_of(arguments):
    """The folder named on the command line, or the repository of this script."""
    return pathlib.Path(arguments[0]).resolve() if arguments else pathlib.Path(__file__).resolve().parent.parent
