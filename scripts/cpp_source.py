"""What the checks of the house read from C++ sources: includes, code without comments, classes, functions. No compiler."""
import bisect
import dataclasses
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


@dataclasses.dataclass
class Item:
    kind: str        # "class", "enum", "alias", "constant", "function" (with a body) or "declaration" (of one, without)
    name: str        # qualified by its classes
    first: int       # lines, from 1; of a function from its signature on
    last: int
    signature: str = ""
    public: bool = True      # not below a private or protected label, not in detail or an unnamed namespace
    parameters: int = 0


def _closing(code, opening):
    """Offset of the bracket that closes the one at `opening`."""
    pairs = {"(": ")", "[": "]", "{": "}"}
    depth, i = 0, opening
    while i < len(code):
        if code[i] in pairs:
            depth += 1
        elif code[i] in ")]}":
            depth -= 1
            if depth == 0:
                return i
        i += 1
    return len(code) - 1


def _without_angles(text):
    """The text without what stands in <...>."""
    text = re.sub(r"operator\s*(<=>|<<=?|>>=?|<=|>=|<|>|->)", "operator_", text)
    text = text.replace("->", "  ").replace("<=", "  ").replace(">=", "  ")
    while (shorter := re.sub(r"<[^<>();{}]*(\([^()]*\)[^<>();{}]*)*>", " ", text)) != text:
        text = shorter
    return text


NOT_NAMES = {"if", "for", "while", "switch", "catch", "return", "sizeof", "alignof", "decltype", "noexcept", "requires", "static_assert",
             "alignas", "explicit", "throw", "new", "delete", "void", "const", "defined", "assert", "__attribute__", "auto"}
CALLED = re.compile(r"((?:~\s*|operator\s*[^\s\w(]+\s*|operator\s*\(\s*\)\s*|operator\s+\w+\s*)|[A-Za-z_]\w*)\s*\(")


def _function(head):
    """(name, number of parameters) of a signature, or None."""
    plain = re.sub(r"\[\[[^\]]*\]\]", " ", head)
    plain = re.sub(r"\balignas\s*\([^()]*\)", " ", plain)
    plain = _without_angles(re.sub(r"operator\s*\(\s*\)", "operator_call", plain))
    plain = re.sub(r"\brequires\b.*?(?=\b[A-Za-z_]\w*\s*\()", " ", plain) if "requires" in plain else plain
    for match in re.finditer(r"(~?\s*\b[A-Za-z_]\w*|operator\s*[^\s\w(]+|operator\s+[\w:]+[&*\s]*)\s*\(", plain):
        name = re.sub(r"\s+", "", match.group(1))
        if name in NOT_NAMES:
            continue
        before = plain[: match.start()]
        if re.search(r"=\s*$", before) or re.search(r"[=,(]", re.sub(r"operator\s*[^\s\w(]+|\([^()]*\)", "", before)):
            return None  # an initialiser, a call in an argument
        opening = match.end() - 1
        inner = plain[opening + 1 : _closing(plain, opening)]
        depth, count = 0, 1 if inner.strip() not in ("", "void") else 0
        for c in inner:
            depth += c in "([{"
            depth -= c in ")]}"
            count += c == "," and depth == 0
        return name, count
    return None


def items(text):
    """Classes, enumerations, aliases, constants and functions, in the order of their beginnings; bodies are not entered."""
    code = code_of(text)
    line_of = _lines(code)
    found = []
    _scan(code, 0, len(code), [], True, False, line_of, found)
    return found


NAMED = {"alias": re.compile(r"\s*(?:template\s*<.*>\s*)?using\s+(\w+)\s*=", re.DOTALL),
         "constant": re.compile(r"\s*(?:static\s+|inline\s+)*constexpr\b[^=({]*?\b(\w+)\s*(?:\[[^\]]*\]\s*)*(?:=|\{)")}


def _named(head):
    """(kind, name) of a statement that gives a type or a value a name, or None."""
    for kind, pattern in NAMED.items():
        if match := pattern.match(head):
            return kind, match.group(1)
    return None


def _lines(code):
    starts = [0] + [m.end() for m in re.finditer("\n", code)]
    return lambda offset: bisect.bisect_right(starts, offset)


def _scan(code, begin, end, scope, public, in_class, line_of, found):
    start = i = begin
    while i < end:
        c = code[i]
        if c in "([":
            i = _closing(code, i) + 1
            continue
        if c == ";":
            head = re.sub(r"\{.*\}", "", code[start:i], flags=re.DOTALL)  # the value of a variable
            if named := _named(code[start:i]):
                at = start + len(head) - len(head.lstrip())
                found.append(Item(named[0], "::".join(scope + [named[1]]), line_of(at), line_of(i), head.strip(), public))
            elif not re.match(r"\s*(using|typedef|friend\s+(class|struct)|static_assert|extern\s+template)\b", head):
                called = _function(head)
                if called and _is_declaration(head, in_class):
                    at = start + len(head) - len(head.lstrip())
                    found.append(Item("declaration", "::".join(scope + [called[0]]), line_of(at), line_of(i), head.strip(), public, called[1]))
            start = i + 1
        elif c == ":" and in_class and re.search(r"\b(public|private|protected)\s*$", code[start:i]):
            public = code[start:i].strip().startswith("public") and "detail" not in scope
            start = i + 1
        elif c == "{":
            head, close = code[start:i], _closing(code, i)
            at = start + len(head) - len(head.lstrip())
            bare = re.sub(r"\[\[[^\]]*\]\]|\balignas\s*\([^()]*\)", " ", head)
            bare = re.sub(r"^\s*(template\s*<(?:[^<>]|<(?:[^<>]|<[^<>]*>)*>)*>\s*(requires[^{;]*?(?=\b(class|struct)\b))?)+", " ", bare)
            kind = re.match(r"\s*(?:(?:static|inline|constexpr|const|typedef)\s+)*(inline\s+namespace|namespace|class|struct|union|enum(?:\s+class)?|extern)\b\s*([\w:]*)", bare)
            if kind and kind.group(1).endswith("namespace"):
                hidden = kind.group(2) in ("", "detail")
                _scan(code, i + 1, close, scope if not hidden else scope + ["detail"], public and not hidden, False, line_of, found)
            elif kind and kind.group(1) == "extern":
                _scan(code, i + 1, close, scope, public, False, line_of, found)
            elif kind and not kind.group(1).startswith("enum") and "(" not in _without_angles(bare):
                name = kind.group(2) or "unnamed"
                found.append(Item("class", "::".join(scope + [name]), line_of(at), line_of(close), head.strip(), public))
                own = kind.group(1) != "class"
                _scan(code, i + 1, close, scope + [name], public and own, True, line_of, found)
            elif kind:
                found.append(Item("enum", "::".join(scope + [kind.group(2) or "unnamed"]), line_of(at), line_of(close), head.strip(), public))
            else:
                called = _function(head)
                if called:
                    # Initialisers in braces before the body: name(...) : a{1}, b{2} {
                    while re.match(r"\s*(,|\{)", code[close + 1 : close + 200]) and ":" in re.sub(r"::", "", head[head.find("(") :]):
                        i = code.index("{", close + 1)
                        close = _closing(code, i)
                    found.append(Item("function", "::".join(scope + [called[0]]), line_of(at), line_of(close), head.strip(), public, called[1]))
                elif "[" in head and re.search(r"=\s*\[", head):
                    pass  # a variable that is a lambda, handled below
                else:
                    i = close + 1  # the value of a variable
                    continue
            i = close + 1
            start = i
            continue
        i += 1


def _is_declaration(head, in_class):
    """Whether a statement with name(...) declares a function rather than a variable with an argument or a call."""
    plain = re.sub(r"\[\[[^\]]*\]\]", " ", _without_angles(head)).strip()
    if re.match(r"(return|delete|throw|goto)\b", plain):
        return False
    before = plain[: plain.find("(")].strip() if "(" in plain else plain
    words = re.findall(r"[~\w:]+|operator\S*", before)
    if len(words) >= 2 or "operator" in before:
        return True
    return in_class and len(words) == 1 and not before.isupper()  # a constructor


def includes(text):
    """(line, file) of each #include outside comments."""
    for number, line in enumerate(text.split("\n"), 1):
        match = re.match(r'\s*#\s*include\s*[<"]([^">]+)[">]', line)
        if match:
            yield number, match.group(1)
