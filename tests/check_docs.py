"""The check of what the documentation promises: equations and links resolve, public numbers have a unit.

  equations  every number (n.m) that code, plans or pages cite stands on a page of docs/equations/, once, with its
             origin; no descriptor's .source cites such a number, since no publication has it; code cites them as
             "docs/equations (n.m)" or as (n.m) alone
  links      every relative link of a page leads to a file, and to a heading where it names one
  units      a public function that takes or returns a double, span, Matrix or vector<double> says a unit or a shape in
             square brackets: [rad/s], [u], [1], [N x p]
  words      no comment of a public header begins with "The same"
  numbers    the versions of files that RELEASING.md states are those of the code
  code       a block of a page below the comment <!-- from FILE --> or <!-- not run: from FILE --> stands in that file, line
             for line; in docs/adding/ every block of C++, TypeScript, TOML and JSON has such a comment

    check_docs.py REPOSITORY      exit 1 and one line a fault; prints how many functions say a unit
    check_docs.py --self-test     a sound small tree passes, and every kind of tampering with it is caught
"""

import re

import check_tools

PAGES = "docs/equations"

CITATION = re.compile(r"(?<![\w.)\]])\(([1-9])\.([1-9]\d?)\)")
TAG = re.compile(r"\\tag\{(\d+\.\d+)\}")
FOREIGN = re.compile(r"\b[Ee]qs?\. \(\d\.\d+\)")
SOURCE = re.compile(r"\.source\s*=\s*((?:\"[^\"]*\"\s*)+)")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
NUMERIC = re.compile(r"\bdouble\b|\bspan<|\bMatrix\b")
BRACKET = re.compile(r"(?<![\w)])\[([^\[\]\n]{1,60})\]")
PLAN_TABLES = {"settings", "site", "rig", "channels", "truth", "limit", "instrument", "schedule", "recording", "beside"}
ACCESS = ("public", "private", "protected")
FROM = re.compile(r"(?m)^<!-- (?:not run: )?from (\S+) -->\n```\w+\n((?:.*\n)*?)```$|^```(cpp|tsx|toml|json)\n")
ALL_FROM_FILES = "docs/adding/"
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"\((?:.|\n)*?\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', re.S)
NUMBERS = {  # rows of the table in RELEASING.md, and what says the number in the file that the row names
    "result JSON": r"project\(tumble VERSION ([\d.]+)",
    "archive, SQLite and PostgreSQL": r"newest_version\(\) \{ return (\d+); \}",
    "live store of a run": r"PRAGMA user_version = (\d+);|version\.integer\(1\) != (\d+)\)",
}
NO_FUNCTION = {"double", "int", "bool", "void", "char", "if", "return", "decltype", "noexcept", "alignas"}


# ---- which files ------------------------------------------------------------------------------------------------


def public_headers(root):
    """Headers whose functions others may call: all but those that only tests use."""
    return sorted(p for p in (root / "tumble").rglob("*.hpp") if "testing" not in p.relative_to(root).parts)


def citing_files(root):
    suffixes = {".hpp", ".cpp", ".md", ".toml", ".txt", ".py", ".ts"}
    for folder in ("tumble", "apps", "docs", "plans", "tests", "bench", "examples", "python"):
        for path in sorted((root / folder).rglob("*")):
            parts = path.relative_to(root).parts
            if path.suffix in suffixes and "node_modules" not in parts and parts[:2] not in (
                    ("tests", "reference"), ("tests", "fuzz")) and path.name != "check_docs.py":
                yield path
    yield from sorted(root.glob("*.md"))


# ---- equations and links ----------------------------------------------------------------------------------------


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def equation_pages(root):
    """({number: page}, faults): each number once, in a section of its own that says its origin."""
    numbers, faults = {}, []
    for path in sorted((root / PAGES).glob("*.md")):
        name, text = path.relative_to(root), path.read_text(encoding="utf-8")
        for section in re.split(r"(?m)^(?=#+ )", text):
            begin = text.index(section)
            for tag in TAG.findall(section):
                where = f"{name}:{line_of(text, begin)}"
                if tag in numbers:
                    faults.append(f"{where}: ({tag}) stands on {numbers[tag]} too")
                numbers[tag] = name
                if f"({tag})" not in section.split("\n", 1)[0]:
                    faults.append(f"{where}: the heading does not name ({tag})")
                if "\nOrigin: " not in section:
                    faults.append(f"{where}: ({tag}) has no origin")
    return numbers, faults


def words_of_cpp(text):
    """Comments and strings of a C++ file, everything else blanked."""
    kept, last = [], 0
    for match in TOKEN.finditer(text):
        kept += [re.sub(r"[^\n]", " ", text[last:match.start()]), match[0]]
        last = match.end()
    return "".join(kept)


def check_equations(root):
    numbers, faults = equation_pages(root)
    for path in citing_files(root):
        name, text = path.relative_to(root), path.read_text(encoding="utf-8")
        if path.suffix in (".hpp", ".cpp"):
            for match in SOURCE.finditer(text):
                for number in CITATION.finditer(match[1]):
                    faults.append(f"{name}:{line_of(text, match.start())}: .source cites {number[0]}, a number of ours")
            text = words_of_cpp(text)
            for match in FOREIGN.finditer(text):
                faults.append(f'{name}:{line_of(text, match.start())}: "{match[0]}": write docs/equations (n.m)')
        for match in CITATION.finditer(text):
            if f"{match[1]}.{match[2]}" not in numbers:
                faults.append(f"{name}:{line_of(text, match.start())}: {match[0]} stands on no page of {PAGES}")
    return faults


def anchors_of(path):
    """Anchors of a page's headings as GitHub makes them."""
    text = re.sub(r"(?ms)^```.*?^```", "", path.read_text(encoding="utf-8"))
    anchors = set()
    for heading in re.findall(r"(?m)^#+ +(.*?)\s*$", text):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")
        number, unique = 0, anchor
        while unique in anchors:
            number += 1
            unique = f"{anchor}-{number}"
        anchors.add(unique)
    return anchors


def check_links(root):
    faults = []
    for path in sorted((root / "docs").rglob("*.md")) + sorted(root.glob("*.md")):
        name, text = path.relative_to(root), path.read_text(encoding="utf-8")
        text = re.sub(r"(?ms)^```.*?^```", lambda m: re.sub(r"[^\n]", " ", m[0]), text)
        text = re.sub(r"`[^`\n]*`", lambda m: " " * len(m[0]), text)
        for match in LINK.finditer(text):
            target, _, anchor = match[1].partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            other = (path.parent / target) if target else path
            where = f"{name}:{line_of(text, match.start())}"
            if not other.exists():
                faults.append(f"{where}: the link {match[1]} leads to no file")
            elif anchor and other.suffix == ".md" and anchor not in anchors_of(other):
                faults.append(f"{where}: the link {match[1]} leads to no heading")
    return faults


def check_decisions(root):
    """Each decision has a number of its own and stands once in the index by subject."""
    folder, faults, names = root / "docs/decisions", [], {}
    index = (folder / "README.md").read_text(encoding="utf-8") if (folder / "README.md").exists() else ""
    for path in sorted(folder.glob("[0-9]*.md")):
        count = index.count(f"({path.name})")
        if count != 1:
            faults.append(f"docs/decisions/README.md: {path.name} stands {count} times in the index, expected once")
        other = names.setdefault(path.name[:3], path.name)
        if other != path.name:
            faults.append(f"docs/decisions/{path.name}: {other} has this number too")
    return faults


def check_numbers(root):
    """Rows of RELEASING.md whose number is not the one of the file that they name."""
    faults, rows = [], {}
    for line in (root / "RELEASING.md").read_text(encoding="utf-8").splitlines():
        if len(cells := [cell.strip() for cell in line.strip("|").split("|")]) == 4:
            rows[cells[0]] = (cells[2], cells[3].strip("`"))
    for name, pattern in NUMBERS.items():
        number, file = rows.get(name, ("", ""))
        code = (root / file).read_text(encoding="utf-8") if file else ""
        said = {"".join(match.groups("")) for match in re.finditer(pattern, code)}
        if said != {number}:
            faults.append(f"RELEASING.md: {name}: {number or 'no number'}, but {file or 'no file'} says "
                          f"{', '.join(sorted(said)) or 'none'}")
    return faults


# ---- code of pages ----------------------------------------------------------------------------------------------


def check_code(root):
    """Blocks of C++ that do not stand in the file that they are said to come from."""
    faults = []
    for path in sorted((root / "docs").rglob("*.md")) + sorted(root.glob("*.md")):
        name, text = path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")
        for match in FROM.finditer(text):
            where = f"{name}:{line_of(text, match.start())}"
            if match[1] is None:
                if name.startswith(ALL_FROM_FILES):
                    faults.append(f"{where}: a block of {match[3]} without <!-- from FILE -->")
                continue
            source = root / match[1]
            code = "\n" + source.read_text(encoding="utf-8") if source.exists() else ""
            if "\n" + match[2] not in code:
                faults.append(f"{where}: this block does not stand in {match[1]}")
    return faults


# ---- units of public functions ----------------------------------------------------------------------------------


def code_of(text):
    """A header without comments, strings and preprocessor lines; every line keeps its number."""
    blank = lambda match: re.sub(r"[^\n]", " ", match[0])
    return re.sub(r"(?m)^\s*#(?:[^\n]*\\\n)*[^\n]*$", blank, TOKEN.sub(blank, text))


def statements(code):
    """[(first line, last line, words, what ends it)] of everything between ; { } and access labels."""
    words, depth, line, begin = "", 0, 1, 1
    for char in code:
        if not words.strip():
            begin = line
        depth += {"(": 1, ")": -1}.get(char, 0)
        if depth == 0 and (char in ";{}" or (char == ":" and words.strip() in ACCESS)):
            yield begin, line, " ".join(words.split()), char
            words = ""
        else:
            words += char
        line += char == "\n"


def public_functions(text):
    """[[first line, last line, declaration]] of the functions that others may call."""
    found, scopes = [], [{"outer": True, "public": True, "function": None}]
    for begin, end, words, stop in statements(code_of(text)):
        scope = scopes[-1]
        if stop == ":":
            scope["public"] = scope["outer"] and words == "public"
        elif stop == "}":
            scopes.pop()
            if scope["function"] is not None:
                found[scope["function"]][1] = end
        else:
            is_new = scope["public"] and is_function(words)
            if is_new:
                found.append([begin, end, words])
            if stop == "{":
                plain, inside = strip_templates(words), False
                if not is_new and "(" not in plain:
                    inside = scope["public"] and re.search(r"\b(namespace(?! detail)|struct|class|union)\b", plain)
                starts = bool(inside) and not re.search(r"\bclass\b", plain) and not plain.startswith("enum")
                scopes.append({"outer": bool(inside), "public": starts, "function": len(found) - 1 if is_new else None})
    return found


def comments_of(text):
    """({line: comment on a line of its own}, {line: comment ///< behind something or continuing one})."""
    above, behind = {}, {}
    for match in TOKEN.finditer(text):
        line = line_of(text, match.start())
        if match[0].startswith("///<"):
            behind[line] = match[0]
        elif match[0].startswith("///"):
            above[line] = match[0]
    return above, behind


def documented_functions(text):
    """[(line, declaration, comment)]: one right below another, without a comment above it, shares that of the other."""
    above, behind = comments_of(text)
    result, block, last = [], [], None
    for begin, end, words in public_functions(text):
        line, own = begin - 1, []
        while line in above:
            own.insert(0, above[line])
            line -= 1
        block = own or (block if last == begin - 1 else [])
        line, note = begin, []
        while line <= end or line in behind:
            note.append(behind.get(line, ""))
            line += 1
        result.append((begin, words, "\n".join(block + note)))
        last = end
    return result


def strip_templates(words):
    words = re.sub(r"operator\s*(\(\)|\[\]|[<>=!+\-*/]+)", "operator_", words).replace("->", "  ")
    while re.search(r"<[^<>]*>", words):
        words = re.sub(r"<[^<>]*>", "", words)
    return words


def is_function(words):
    """Whether a declaration is that of a function, and not of a variable, an alias or a friend."""
    if re.match(r"(using|typedef|friend|static_assert|extern)\b", words) or words.endswith(("= delete", "= default")):
        return False
    head = strip_templates(words).split("=")[0] if "operator" not in words else strip_templates(words)
    match = re.search(r"([\w~]+)\s*\(", head)
    return bool(match) and match[1] not in NO_FUNCTION


def says_unit(comment):
    return any(m not in PLAN_TABLES for m in BRACKET.findall(comment))


def numeric_functions(path):
    """[(line, declaration, whether its comment says a unit or a shape)] of the public functions with numbers."""
    return [(line, words, says_unit(comment)) for line, words, comment in documented_functions(path.read_text("utf-8"))
            if NUMERIC.search(re.split(r"\)\s*(const\s*)?:\s", words)[0])]


def check_units(root):
    """Faults of the public headers, and how many of their functions with numbers say a unit or a shape."""
    faults, total, said = [], 0, 0
    for path in public_headers(root):
        name = path.relative_to(root).as_posix()
        for line, words, has_unit in numeric_functions(path):
            total += 1
            said += has_unit
            if not has_unit:
                short = words if len(words) < 90 else words[:87] + "..."
                faults.append(f"{name}:{line}: no unit or shape in brackets: {short}")
        faults += [f'{name}:{line}: a comment begins with "The same": say what it is' for line in same_as_what(path)]
    share = 100 * said / total if total else 100
    return faults, f"units and shapes: {said} of {total} public functions with numbers ({share:.1f} %)"


def same_as_what(path):
    """Numbers of the lines where a comment begins with "The same"."""
    lines = path.read_text(encoding="utf-8").splitlines()
    for number, line in enumerate(lines, 1):
        continued = number > 1 and line.strip().startswith("//") and lines[number - 2].strip().startswith("//")
        if re.search(r"//[/<! ]*The same\b", line) and ("///<" in line or not continued):
            yield number


def check(root):
    faults, report = check_units(root)
    return check_equations(root) + check_links(root) + check_decisions(root) + check_numbers(root) + check_code(root) + faults, report


# ---- self-test --------------------------------------------------------------------------------------------------

PAGE = "# 2. Tables\n\n### (2.1) Rate\n\n```math\nw = v/r \\tag{2.1}\n```\n\nOrigin: derived here.\n"
HEADER = """#pragma once
namespace tumble {
struct Point {
  double x = 0.0;  ///< anything
  double norm() const;  ///< [m]
  double twice() const { return 2.0 * x; }  ///< [m]
  /// Of the index [m].
  double operator()(int i) const { return x * i; }
  bool empty() const { return false; }
 private:
  double hidden() const;
};
using Function = double (*)(double);
/// Ratio of the two [1].
double ratio(double above, double below = 1.0);
double inverse(double above,
               double below);
/// Given     x   samples [u], length N
std::vector<double> means(std::span<const double> x, const std::vector<int>& sizes = {});
/// A name.
std::string name(int number);
inline bool operator==(const Point& a, const Point& b) { return a.x == b.x; }
}  // namespace tumble
"""
SOUND = {
    "README.md": "See [the tables](docs/equations/tables.md#21-rate) and [the site](https://example.org).\n",
    "docs/equations/tables.md": PAGE,
    "docs/page.md": "By (2.1); a value of 1 (0.5) is no citation. [up](../README.md) [here](#there)\n\n## There\n",
    "plans/one.toml": 'title = "by (2.1)"\n',
    "tumble/math/point.hpp": HEADER,
    "tumble/math/point.cpp": '// docs/equations (2.1)\ndouble f() { return g(7.3) + std::sqrt(3.0); }\n',
    "tumble/models/m.cpp": 'const M m{.source = "Lee, 2001, eq. (4)-(6); "\n "slide 3"};\n',
    "tumble/methods/x/part.hpp": "/// One line,\n/// The same line goes on.\nint later(int x);\n",
    "tumble/math/testing/help.hpp": "double not_public(double x);\n",
    "examples/adding/my.cpp": "int a() { return 1; }\n\nint b() { return 2; }\n",
    "examples/adding/my.toml": "[command.stop]\nsend = 1\n",
    "docs/adding/verb.md": "<!-- not run: from examples/adding/my.toml -->\n```toml\n[command.stop]\n```\n",
    "docs/adding/my.md": "<!-- from examples/adding/my.cpp -->\n```cpp\nint b() { return 2; }\n```\n",
    "docs/decisions/README.md": "[1](001-one.md)\n",
    "docs/decisions/001-one.md": "# One\n",
    "RELEASING.md": "| result JSON | member | 0.1.0 | `CMakeLists.txt` |\n"
                    "| archive, SQLite and PostgreSQL | table | 3 | `archive.cpp` |\n"
                    "| live store of a run | file | 1 | `store.cpp` |\n",
    "CMakeLists.txt": "project(tumble VERSION 0.1.0)\n",
    "archive.cpp": "int newest_version() { return 3; }\n",
    "store.cpp": 'run("PRAGMA user_version = 1;");\nif (version.integer(1) != 1) refuse();\n',
    "docs/other.md": "```cpp\nint c() { return 3; }\n```\n",
}
TAMPERED = {  # file, its new text, words of the fault
    "number without a page": ("plans/one.toml", "# (2.2)\n", "(2.2) stands on no page"),
    "in a comment": ("tumble/math/point.cpp", "// by (3.1)\n", "(3.1) stands on no page"),
    "in a string": ("tumble/math/point.cpp", 'auto t = "by (3.1)";\n', "(3.1) stands on no page"),
    "number of ours in a source": ("tumble/models/m.cpp", 'M m{.source = "Lee, "\n "(2.1)"};\n', "a number of ours"),
    "eq. with a number of ours": ("tumble/math/point.cpp", "// eq. (2.1)\n", "write docs/equations"),
    "equation twice": ("docs/equations/more.md", PAGE, "too"),
    "equation without an origin": ("docs/equations/more.md", PAGE.replace("2.1", "2.9").replace("Origin", "By"),
                                   "no origin"),
    "equation without a heading": ("docs/equations/more.md", PAGE.replace("{2.1}", "{2.9}"), "does not name (2.9)"),
    "link to no file": ("docs/page.md", "[x](nowhere.md)\n", "leads to no file"),
    "link to no heading": ("docs/page.md", "[x](../README.md#nowhere)\n", "leads to no heading"),
    "function without a comment": ("tumble/core/a.hpp", "double f(int x);\n", "no unit or shape"),
    "comment without a bracket": ("tumble/core/a.hpp", "/// Gain.\nMatrix f(int x);\n", "no unit or shape"),
    "span without a unit": ("tumble/core/a.hpp", "/// Of x[i].\nint f(std::span<const int> x);\n", "no unit or shape"),
    "vector without a unit": ("tumble/core/a.hpp", "/// By [settings].\nvoid f(const std::vector<double>& x);\n",
                              "no unit"),
    "member without a unit": ("tumble/core/a.hpp",
                              "class A {\n  int x;\n public:\n  double f() const { return 1; }\n};\n", "no unit"),
    "member below one with a note": ("tumble/core/a.hpp", "struct A {\n  double f() const;  ///< [m]\n  double g() const;\n};\n",
                                     "no unit"),
    "blank line ends the comment": ("tumble/core/a.hpp", "/// [s]\n\ndouble f();\n", "no unit or shape"),
    "in a room below a module": ("tumble/core/room/a.hpp", "double f();\n", "no unit or shape"),
    "call operator": ("tumble/core/a.hpp",
                      "struct A {\n  double operator()(int i) const { return i; }\n  int f();\n};\n", "no unit"),
    "template": ("tumble/core/a.hpp", "template <class T>\nstd::vector<double> f(T x) {\n  return {};\n}\n", "no unit"),
    "decision without a place": ("docs/decisions/002-two.md", "# Two\n", "stands 0 times"),
    "decision twice": ("docs/decisions/README.md", "[1](001-one.md) [2](001-one.md)\n", "stands 2 times"),
    "code that has changed": ("examples/adding/my.cpp", "int b() { return 3; }\n", "does not stand in"),
    "code of a part of a line": ("examples/adding/my.cpp", "// int b() { return 2; }\n", "does not stand in"),
    "code of another language that has changed": ("examples/adding/my.toml", "[command.halt]\n", "does not stand in"),
    "code from no file": ("docs/adding/my.md", "<!-- from my.cpp -->\n```cpp\nint b();\n```\n", "does not stand in"),
    "code without its file": ("docs/adding/my.md", "```cpp\nint b() { return 2; }\n```\n", "cpp without <!-- from"),
    "toml without its file": ("docs/adding/verb.md", "```toml\n[command.stop]\n```\n", "toml without <!-- from"),
    "a version that was raised": ("CMakeLists.txt", "project(tumble VERSION 0.2.0)\n", "0.1.0, but CMakeLists.txt says 0.2.0"),
    "tables that were changed": ("archive.cpp", "int newest_version() { return 4; }\n", "says 4"),
    "two numbers of one store": ("store.cpp", 'run("PRAGMA user_version = 2;");\nif (version.integer(1) != 1) refuse();\n',
                                 "says 1, 2"),
    "a version that nothing says": ("archive.cpp", "\n", "says none"),
    "begins with The same": ("tumble/core/a.hpp", "/// The same for two.\nint f(int x);\n", 'begins with "The same"'),
}


def self_test():
    return check_tools.faults_of_tampering(lambda root: check(root)[0], SOUND, TAMPERED)


if __name__ == "__main__":
    check_tools.main(__doc__, check, self_test, "docs check passed")
