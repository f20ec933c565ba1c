"""The check of words: no text for users has a phrase that docs/english.md says we do not write.

The phrases are the first column of the table of words in docs/english.md. Looked through are the pages (README and the
like, docs/ without decisions/ and equations/; code blocks and `code` do not count), the sentences of text/, and the
string literals of the C++ files in apps/ and tumble/ (tests do not count), and the /// comments of all headers of
tumble/, whose `code` does not count.

No comment of a header begins with What, Of, Those of or The same, which name nothing in the hover text of an editor.

    check_english.py REPOSITORY             exit 1 and one line a fault
    check_english.py --self-test            a sound small tree passes, and every kind of tampering with it is caught
"""

import pathlib
import re

import check_tools

PAGE_OF_WORDS = "docs/english.md"
NOT_PAGES = ("decisions", "equations", "CHANGELOG.md", "english.md")
# Names in the result JSON do not change.
FIXED = {"tumble/tasks/optimisation/report.cpp": ("told", "told apart"),
         "tumble/methods/allan_noise/spectrum.cpp": ("left out",)}
BEGINNING = re.compile(r"///<? *(What|Of|Those of|The same)\b")
COMMENT = re.compile(r"///<?")
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\((?:.*?)\)\1"|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)+\'', re.DOTALL)


def phrases_of(page):
    """The phrases of the table of words, as written in its first column."""
    table = re.search(r"^\| we do not write.*?(?=^$)", page, re.MULTILINE | re.DOTALL)
    rows = table[0].splitlines()[2:] if table else []
    return [phrase for row in rows for phrase in re.findall(r"`([^`]+)`", row.split("|")[1])]


def blanked(match):
    """As many lines, without letters."""
    return re.sub(r"[^\n]", " ", match[0])


def text_of_page(text):
    """The prose of a page; what a program reads or prints is blank."""
    text = re.sub(r"^```.*?^```", blanked, text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]+`|\]\([^)]*\)", blanked, text)


def text_of_source(text):
    """The string literals of a C++ file, at their places; literals that follow each other are one text."""
    out, end = [], 0
    for token in TOKEN.finditer(text):
        out.append(re.sub(r"[^\n\s]", "|", text[end:token.start()]))
        is_text = token[0].startswith('"') and not text[:token.start()].rstrip(" ").endswith("#include")
        out.append(" " + token[0][1:-1] + " " if is_text else blanked(token))
        end = token.end()
    return "".join(out)


def faults_of_text(relative, text, pattern):
    """One line for each phrase in a text whose other characters are blank."""
    return [f"{relative}:{text.count(chr(10), 0, hit.start()) + 1}: '{' '.join(hit[0].split())}'"
            for hit in pattern.finditer(text)]


def text_of_comments(text):
    """The /// comments of a header, at their places; `code` in them is blank."""
    lines = []
    for line in text.split("\n"):
        begin = COMMENT.search(line)
        lines.append(" " * begin.end() + line[begin.end():] if begin else re.sub(r"\S", "|", line))
    return re.sub(r"`[^`\n]+`", blanked, "\n".join(lines))


def paragraphs_of_comments(text):
    """Number and text of the first line of each paragraph of the /// comments of a header."""
    found, before = [], ""
    for number, line in enumerate(text.splitlines(), 1):
        goes_on = before.lstrip().startswith("///") and before.strip() != "///"
        if COMMENT.search(line) and line.strip() != "///" and not (line.lstrip().startswith("/// ") and goes_on):
            found.append((number, line))
        before = line
    return found


def pages(root):
    found = sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md")) + sorted((root / "text").glob("*.toml"))
    return [p for p in found if not any(part in NOT_PAGES for part in p.relative_to(root).parts)]


def sources(root):
    found = [p for folder in ("apps", "tumble") for p in (root / folder).rglob("*.?pp")]
    return sorted(p for p in found if not p.stem.endswith("_test") and "testing" not in p.parts)


def headers(root):
    return sorted((root / "tumble").rglob("*.hpp"))


def check(root):
    """The faults, and a line with the numbers of what was looked through."""
    listed = phrases_of((root / PAGE_OF_WORDS).read_text(encoding="utf-8"))
    if not listed:
        return [f"{PAGE_OF_WORDS}: no table of words found"], ""
    words = "|".join(r"\s+".join(map(re.escape, p.split())) for p in sorted(listed, key=len, reverse=True))
    pattern = re.compile(rf"\b(?:{words})\b", re.IGNORECASE)
    faults, beginnings, paragraphs = [], [], 0
    for path in pages(root):
        faults += faults_of_text(path.relative_to(root), text_of_page(path.read_text(encoding="utf-8")), pattern)
    for path in sources(root):
        relative = path.relative_to(root).as_posix()
        lines = faults_of_text(relative, text_of_source(path.read_text(encoding="utf-8")), pattern)
        lines = [line for line in lines if not line.endswith(tuple(f"'{name}'" for name in FIXED.get(relative, ())))]
        faults += lines
    for path in headers(root):
        relative, text = path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")
        faults += faults_of_text(relative, text_of_comments(text), pattern)
        comments = paragraphs_of_comments(text)
        paragraphs += len(comments)
        beginnings += [f"{relative}:{number}: a comment begins with '{begin[1]}'"
                       for number, line in comments if (begin := BEGINNING.search(line))]
    report = (f"{len(pages(root))} pages, {len(sources(root))} C++ files; {paragraphs} paragraphs of comments in "
              f"{len(headers(root))} headers, {len(beginnings)} begin with What, Of, Those of or The same")
    return [f"{fault}: {PAGE_OF_WORDS} says what we write instead" for fault in faults + beginnings], report


SOUND = {
    PAGE_OF_WORDS: "| we do not write | we write | why |\n|---|---|---|\n| `left out`, `told` | skip | x |\n\nleft out\n",
    "README.md": "Nothing is told`told` here: toldness.\n\n```\nleft out\n```\n".replace("is told", "is"),
    "docs/decisions/001.md": "left out\n",
    "CHANGELOG.md": "left out\n",
    "apps/cli/a.cpp": '// left out\n#include "left out"\n/* told */ auto told = "skipped";  // "told"\nchar c = \'"\';\n',
    "tumble/core/b.hpp": "/// A sum of\n/// What is `told`.\nint b;  ///< Offset of what is there\n// told\n",
    "tumble/core/a_test.cpp": 'auto s = "told";\n',
    "tumble/tasks/optimisation/report.cpp": 'column("told");\n',
}
TAMPERED = {  # file, its new text, words of the fault
    "page": ("docs/a/b.md", "A sample\nis Told so.\n", "docs/a/b.md:2: 'Told'"),
    "page, over two lines": ("README.md", "a\nb left\nout c\n", "README.md:2: 'left out'"),
    "sentence of a finding": ("text/en.toml", 'gap = "a sample is told"\n', "text/en.toml:1: 'told'"),
    "program": ("apps/cli/a.cpp", 'auto s = "x";\nauto t = "is left out";\n', "apps/cli/a.cpp:2: 'left out'"),
    "program, over two literals": ("tumble/core/a.cpp", 'say("is left "\n    "out");\n', "tumble/core/a.cpp:1: 'left out'"),
    "raw literal before it": ("tumble/core/a.cpp", 'a(R"(" // )");\nsay("told");\n', "tumble/core/a.cpp:2: 'told'"),
    "quote in a literal": ("tumble/core/a.hpp", 'say("\\"//"); say("told");\n', "tumble/core/a.hpp:1: 'told'"),
    "comment of a member": ("tumble/core/a.hpp", "int a;  ///< Told\n", "tumble/core/a.hpp:1: 'Told'"),
    "comment, over two lines": ("tumble/core/a.hpp", "/// A sum left\n/// out.\n", "tumble/core/a.hpp:1: 'left out'"),
    "comment in a header of tests": ("tumble/core/testing/a.hpp", "/// It is told.\n", "testing/a.hpp:1: 'told'"),
    "comment that names nothing": ("tumble/core/a.hpp", "/// What it is.\n", "a.hpp:1: a comment begins with 'What'"),
    "paragraph that names nothing": ("tumble/a.hpp", "/// A sum.\n///\n/// Of all.\n", "a.hpp:3: a comment begins with 'Of'"),
    "member that names nothing": ("tumble/a.hpp", "int a;  ///< The same\n", "a.hpp:1: a comment begins with 'The same'"),
    "second member": ("tumble/a.hpp", "int a;  ///< a\nint b;  ///< Those of a\n", "a comment begins with 'Those of'"),
    "no list": (PAGE_OF_WORDS, "words\n", "no table of words"),
}


def self_test():
    return check_tools.faults_of_tampering(lambda root: check(root)[0], SOUND, TAMPERED)


if __name__ == "__main__":
    check_tools.main(__doc__, check, self_test, "no phrase that we do not write")
