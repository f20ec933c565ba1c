"""The check of findings: code at each place where one is made, text/en.toml and docs/findings.md agree.

A place is `{Severity::x, "code", {{"name", value}, ...}, where, {count, first, worst}}` in tumble/, apps/ or
examples/adding/ (tests do not count). Its code is written there, also as `condition ? "a" : "b"`.

  codes         every code stands in [finding] of text/en.toml, and every code of the table is written somewhere
  phrases       every Phrase{"key"} stands in [phrase], and every key of the table is written somewhere
  placeholders  what a sentence puts between braces is a value of each place that uses it, or {count}, or {first} or
                {worst} where the place gives them. Where values come from a variable, the names written in the file count
  format        what follows the colon of a placeholder is one of the words and formats of tumble/core/finding.hpp
  thresholds    docs/findings.toml: every code stands in [finding], and every constant in the file that is named
  page          the table of docs/findings.md is that of text/en.toml and docs/findings.toml

A place that takes its code from a variable is counted: the code is looked for in the whole file.

    check_findings.py REPOSITORY            exit 1 and one line a fault; prints how many places take their code from a variable
    check_findings.py REPOSITORY --own      these, one line each
    check_findings.py REPOSITORY --write    writes the table of docs/findings.md
    check_findings.py --self-test           a sound small tree passes, and every kind of tampering with it is caught
"""

import math
import pathlib
import re
import sys
import tomllib

import check_tools

TABLE = "text/en.toml"
PAGE = "docs/findings.md"
WHEN = "docs/findings.toml"
BEGIN, END = "<!-- codes: made by tests/check_findings.py --write -->\n", "<!-- end of codes -->\n"
COMMENT = re.compile(r'//[^\n]*|/\*.*?\*/|("(?:[^"\\\n]|\\.)*")', re.DOTALL)
LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
CODE = re.compile(r"[a-zA-Z]\w*$")
SEVERITY = r"(?:(?:\w+::)*Severity::|(?<![\w:.\"]))(?:info|warning|error)\b"
FIRST = re.compile(rf"(?:[^{{}};]*\?\s*)?{SEVERITY}(?:\s*:\s*(?:[^{{}};]*\?\s*)?{SEVERITY})*$", re.DOTALL)
PLACEHOLDER = re.compile(r"\{(\w+)(?::([^}]*))?\}")
CONSTANT = re.compile(r"\{([\w/]+\.[ch]pp):(\w+)(?::(%|deg))?\}")
FORMAT = re.compile(r"(?:exact|difference|duration|instant|bytes|[a-z][a-z ]*|[+]?(?:\.\d+)?[efg]?(?: \S.*)?)$")


def without_comments(text):
    return COMMENT.sub(lambda match: match[1] or re.sub(r"[^\n]", " ", match[0]), text)


def arguments_of(text, begin):
    """What stands between the bracket at `begin` and its partner, split at its commas; None: no partner."""
    parts, depth, start, i = [], 0, begin + 1, begin + 1
    while i < len(text):
        if text[i] == '"':
            i = LITERAL.match(text, i).end() - 1 if LITERAL.match(text, i) else i
        elif text[i] in "([{":
            depth += 1
        elif text[i] in ")]}":
            if depth == 0:
                return parts + [text[start:i].strip()]
            depth -= 1
        elif text[i] in ",;" and depth == 0:
            parts.append(text[start:i].strip())
            start = i + 1
        i += 1
    return None


def opening_before(text, position):
    """Where the bracket opens that `position` stands in; -1: in none."""
    depth = 0
    for i in range(position - 1, -1, -1):
        if text[i] in ")]}":
            depth += 1
        elif text[i] in "([{":
            if depth == 0:
                return i
            depth -= 1
        elif text[i] == ";" and depth == 0:
            return -1
    return -1


def sites_of(text):
    """(position, arguments) of every finding that a C++ file makes; comments are blank already."""
    bare = re.search(r"using enum (?:\w+::)*Severity;", text)
    opened = set()
    for match in re.finditer(SEVERITY, text):
        if "Severity" not in match[0] and not bare:
            continue
        begin = opening_before(text, match.start())
        if begin < 0 or begin in opened:
            continue
        opened.add(begin)
        arguments = arguments_of(text, begin)
        called = text[:begin].rstrip().endswith("Finding")
        if arguments and len(arguments) > 1 and FIRST.match(arguments[0]) and (text[begin] == "{" or called):
            yield begin, arguments


def literals_of(text):
    """Texts that an expression gives: literals that follow each other are one, those it compares with do not count."""
    text = re.sub(r'[!=]=\s*"(?:[^"\\\n]|\\.)*"', "", text)
    return LITERAL.findall(re.sub(r'"\s*\n\s*"', "", text))


def names_given(arguments, text):
    """Names that a sentence may use at this place."""
    values = arguments[2] if len(arguments) > 2 else ""
    entries = [entry for entry in (arguments_of(values, 0) or []) if entry] if values.startswith("{") else [values]
    written = [re.match(r'\{\s*"(\w+)"', entry) for entry in entries]
    names = {"count"} | {match[1] for match in written if match}
    if not all(written) and values or "values.push_back" in text or "values.emplace_back" in text:
        names |= set(re.findall(r'[{(]\s*"(\w+)"\s*,', text))
    often = arguments[4] if len(arguments) > 4 else ""
    places = arguments_of(often, 0) if often.startswith("{") else ["", "x", "x"] if often else []
    names |= {name for name, place in zip(("first", "worst"), places[1:]) if place not in ("{}", "Place()", "Place{}")}
    return names | ({"first", "worst"} if re.search(r"\boccurrences\b", text) else set())


def templates_of(entry):
    return list(entry.values()) if isinstance(entry, dict) else [entry]


def sources(root):
    found = [p for folder in ("tumble", "apps", "examples/adding") for p in (root / folder).rglob("*.?pp")]
    return sorted(p for p in found if not p.stem.endswith("_test") and "testing" not in p.relative_to(root).parts)


def faults_of_site(where, arguments, text, table):
    """Faults of one place, and whether its code comes from a variable."""
    codes = literals_of(arguments[1])
    if not codes or not all(CODE.match(code) for code in codes):
        return [], True
    faults = []
    from_variable = len(arguments) > 2 and not arguments[2].startswith("{")
    prefixes = tuple(re.findall(r'"(\w+_)"\)?\s*\+', text)) if from_variable else ()  # std::string("output_") + axis
    for code in codes:
        if code not in table:
            faults.append(f"{where}: '{code}' does not stand in [finding] of {TABLE}")
            continue
        given = names_given(arguments, text)
        wanted = {name for template in templates_of(table[code]) for name, _ in PLACEHOLDER.findall(template)}
        missing = {name for name in wanted - given if not name.startswith(prefixes)}
        faults += [f"{where}: '{code}' has no value '{name}'" for name in sorted(missing)]
    return faults, False


def faults_of_table(section, entries, written):
    faults = []
    for key, entry in entries.items():
        if key not in written:
            faults.append(f"{TABLE}: [{section}] {key} is used nowhere")
        if isinstance(entry, dict) and set(entry) != {"one", "other"}:
            faults.append(f"{TABLE}: [{section}] {key} has {', '.join(entry)}, expected one and other")
        for template in templates_of(entry):
            faults += [f"{TABLE}: [{section}] {key}: nobody knows the format '{how}' of '{name}'"
                       for name, how in PLACEHOLDER.findall(template) if not FORMAT.match(how)]
    return faults


def number_of(root, file, name):
    """The value of a constant of a file of tumble/; None: it is not there, or its value is no number."""
    path = root / "tumble" / file
    text = without_comments(path.read_text(encoding="utf-8")) if path.is_file() else ""
    match = re.search(rf"\bconstexpr [^;]*?\b{name} =\s*([-\w.*/+ ]+)[,;]", text)
    if not match or not re.fullmatch(r"(?:[\d.]+(?:e-?\d+)?|pi|two_pi|[*/+ -])+", match[1]):
        return None
    return eval(match[1], {"__builtins__": {}}, {"pi": math.pi, "two_pi": 2.0 * math.pi})  # digits and signs only


def clauses_of(root, table):
    """When a threshold decides, by code, with the values of its constants; and faults."""
    path = root / WHEN
    entries = tomllib.loads(path.read_text(encoding="utf-8"))["when"] if path.is_file() else {}
    faults = [f"{WHEN}: '{code}' does not stand in [finding] of {TABLE}" for code in entries if code not in table]

    def shown(match):
        value = number_of(root, match[1], match[2])
        if value is None:
            faults.append(f"{WHEN}: there is no number {match[2]} in tumble/{match[1]}")
            return match[0]
        return f"{value * {None: 1.0, '%': 100.0, 'deg': 180.0 / math.pi}[match[3]]:.4g}" + f" {match[3]}" * bool(match[3])

    return {code: CONSTANT.sub(shown, clause) for code, clause in entries.items()}, faults


def rows_of(entries, clauses):
    """The table of the page: a code, its sentences, and when a threshold decides."""
    rows = ["| code | sentence | decides |\n|---|---|---|\n"]
    for code, entry in sorted(entries.items()):
        said = "<br>".join(f"`{template}`" for template in templates_of(entry)).replace("|", "\\|")
        rows.append(f"| `{code}` | {said} | {clauses.get(code, '')} |\n".replace("|  |", "| |"))
    return "".join(rows)


def page_with(page, rows):
    """The page with other rows; None: it has no place for them."""
    begin, end = page.find(BEGIN), page.find(END)
    return None if begin < 0 or end < begin else page[:begin] + BEGIN + "\n" + rows + "\n" + page[end:]


def table_of(root):
    table = tomllib.loads((root / TABLE).read_text(encoding="utf-8"))
    return table.get("finding", {}), table.get("phrase", {})


def check(root):
    """Faults, and places that take their code from a variable."""
    findings, phrases = table_of(root)
    faults, own, written = [], [], set()
    for path in sources(root):
        text = without_comments(path.read_text(encoding="utf-8"))
        name = path.relative_to(root)
        written |= set(LITERAL.findall(text))
        for begin, arguments in sites_of(text):
            where = f"{name}:{text.count(chr(10), 0, begin) + 1}"
            of_site, has_own = faults_of_site(where, arguments, text, findings)
            faults += of_site
            own += [where] if has_own else []
        for match in re.finditer(r"\bPhrase\{([^{}]*)\}", text):
            faults += [f"{name}:{text.count(chr(10), 0, match.start()) + 1}: '{key}' does not stand in [phrase] of {TABLE}"
                       for key in literals_of(match[1])[:0 if '",' in match[1] else None] if key not in phrases]
    faults += faults_of_table("finding", findings, written) + faults_of_table("phrase", phrases, written)
    page = (root / PAGE).read_text(encoding="utf-8")
    clauses, of_clauses = clauses_of(root, findings)
    faults += of_clauses
    if page != page_with(page, rows_of(findings, clauses)):
        faults.append(f"{PAGE}: the table of codes is not that of {TABLE} and {WHEN}: run tests/check_findings.py . --write")
    return faults, own


SOUND_TABLE = {"gap": "gap of {length:duration} at {first}", "far": "far by {by:.3g deg/h}: {what}, {count:sample}"}
SOUND_PAGE = "codes\n\n" + BEGIN + "\n" + rows_of(SOUND_TABLE, {"far": "above 5 % and 0.1"}) + "\n" + END
SOUND_TOML = ('[finding]\ngap = "gap of {length:duration} at {first}"\nfar = "far by {by:.3g deg/h}: {what}, {count:sample}"\n'
              '[phrase]\nhere = "here"\n')
SOUND_SITE = ('f.push_back({Finding::Severity::info, "gap", {{"length", x, "s"}}, where, {1, t}});\n'
              'return {bad ? Severity::error : Severity::info,\n "far",\n {{"by", f(a, b)}, {"what", Phrase{"here"}}}, c};\n'
              'if (f.severity == Finding::Severity::error) g(Finding::Severity::info, "no finding");\n')
SOUND = {
    TABLE: SOUND_TOML,
    PAGE: SOUND_PAGE,
    WHEN: '[when]\nfar = "above {b/far.cpp:most:%} and {b/far.cpp:least}"\n',
    "tumble/b/far.cpp": "constexpr double most = 0.05, least = 0.1;  // most = 7.0\n",
    "tumble/a.cpp": SOUND_SITE,
    "tumble/own.cpp": '// {Severity::info, "none", {}}\nf({Severity::info, "a gap of " + x, where});\n',
    "tumble/loose.cpp": 'using enum Finding::Severity;\nconst FindingValue by{"by", 1.0};\n'
                        'f({cut ? info : warning, cut ? "far" : "far", {by, {"what", "x"}}, "", often});\n',
    "tumble/a_test.cpp": 'f({Severity::info, "unknown", {}});\n',
}
TAMPERED = {  # file, its new text, words of the fault
    "unknown code": ("tumble/b.cpp", 'f({Severity::info, "unknown", {}});\n', "'unknown' does not stand in [finding]"),
    "unknown code of two": ("tumble/b.cpp", 'f({Severity::info, x == "y" ? "gap" : "no", {{"length", 1.0}}, "", {1, t}});\n',
                            "'no' does not stand"),
    "named Finding": ("tumble/b.cpp", 'Finding(Severity::info, "unknown", {});\n', "'unknown' does not stand in [finding]"),
    "absent value": ("tumble/b.cpp", 'f({Severity::info, "far", {{"what", "x"}}});\n', "'far' has no value 'by'"),
    "absent value with the short name": ("tumble/b.cpp", 'using enum Severity;\nf({info, "far", {{"what", "x"}}});\n',
                                         "'far' has no value 'by'"),
    "absent place": ("tumble/b.cpp", 'f({Severity::info, "gap", {{"length", 1.0}}, "", {3, {}, t}});\n',
                     "'gap' has no value 'first'"),
    "unknown phrase": ("tumble/b.cpp", 'Phrase p = x ? Phrase{"here"} : Phrase{"there"};\n', "'there' does not stand in [phrase]"),
    "unused phrase": (TABLE, SOUND_TOML + 'late = "late"\n', "[phrase] late is used nowhere"),
    "unused code": ("tumble/a.cpp", 'a({Severity::info, "far", {{"by", 1.0}, {"what", Phrase{"here"}}}});\n',
                    "[finding] gap is used nowhere"),
    "unknown format": (TABLE, SOUND_TOML.replace(":duration", ":>8"), "format '>8'"),
    "half a pair": (TABLE, SOUND_TOML.replace("gap =", "gap.one ="), "expected one and other"),
    "unknown constant": ("tumble/b/far.cpp", "constexpr double most = 0.05;\n", "there is no number least"),
    "clause of an unknown code": (WHEN, '[when]\nnear = "below 5"\n', "'near' does not stand in [finding]"),
    "other threshold": ("tumble/b/far.cpp", "constexpr double most = 0.06, least = 0.1;\n", "run tests/check_findings.py"),
    "stale page": (PAGE, SOUND_PAGE.replace("`far`", "`near`"), "run tests/check_findings.py"),
    "page without a table": (PAGE, "codes\n", "run tests/check_findings.py"),
}


def self_test():
    def faults_of(root):
        faults, _ = check(root)
        # A changed table changes the page as well: a fault of its own, tried by itself.
        return faults if len(faults) < 2 else [fault for fault in faults if not fault.startswith(PAGE)]

    failures = check_tools.faults_of_tampering(faults_of, SOUND, TAMPERED)
    with check_tools.tree_of(SOUND) as root:
        own = check(root)[1]
    return failures + ([] if own == ["tumble/own.cpp:2"] else [f"own sentences at {own}, expected tumble/own.cpp:2"])


def write(root):
    path = root / PAGE
    table = table_of(root)[0]
    page = page_with(path.read_text(encoding="utf-8"), rows_of(table, clauses_of(root, table)[0]))
    if page is None:
        sys.exit(f"{PAGE}: no place for the table")
    path.write_text(page, encoding="utf-8")


def main():
    if "--write" in sys.argv:
        return write(pathlib.Path(sys.argv[1]).resolve())
    if "--own" in sys.argv:
        return print("\n".join(check(pathlib.Path(sys.argv[1]).resolve())[1]))

    def reported(root):
        faults, own = check(root)
        return faults, f"places that take their code from a variable: {len(own)}"

    return check_tools.main(__doc__, reported, self_test, "findings, sentences and their page agree")


if __name__ == "__main__":
    main()
