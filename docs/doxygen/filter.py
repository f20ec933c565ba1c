"""What Doxygen is given in place of a header: the comments of Tumble in Doxygen's own words.

    filter.py HEADER        to standard output
    filter.py --self-test

Lines of a comment that are indented further than its text are formulas, written as one reads them:
sigma^2(tau) = 2 ln 2/pi B^2. They become TeX. `Given`, `Returned`, `Throws`, `Accuracy`, `Valid` and `See` at the
beginning of a line, with two blanks or more behind them, become headings of paragraphs.
"""

import re
import sys

GREEK = ("alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi chi psi omega "
         "Delta Sigma Phi Omega").split()
FUNCTIONS = "ln log exp sin cos tan arg min max".split()
SIGNS = {"<=": r"\le ", ">=": r"\ge ", "+-": r"\pm ", "...": r"\ldots ", "~": r"\sim ", "%": r"\%", "#": r"\#",
         "&": r"\&", "inf": r"\infty ", "int": r"\int ", "sum": r"\sum ", " . ": r" \cdot ", "->": r"\to ", "²": "^2", "³": "^3", "µ": r"\mu "}
TOKEN = re.compile(r" {2,}|sqrt\(|\\|->|<=|>=|\+-|\.\.\.| \. |[A-Za-z][A-Za-z]*|.", re.S)
WORD = r"(?:\\text\{ [A-Za-z]+ \}|\\mathrm\{[a-z]+\})"
HEADING = re.compile(r"(Given|Returned|Throws|Accuracy|Valid|See)(\s\s+|$)(.*)")


def closing(text, start):
    """Index of the bracket that closes the one before `start`, or the end."""
    depth = 1
    for i in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[i], 0)
        if depth == 0:
            return i
    return len(text)


def tex(text):
    """A formula of a comment as TeX."""
    out, i = "", 0
    while i < len(text):
        token = TOKEN.match(text, i)[0]
        i += len(token)
        if token == "sqrt(":
            end = closing(text, i)
            out += r"\sqrt{" + tex(text[i:end]) + "}"
            i = end + 1
        elif token == "\\":
            out += r"\backslash "
        elif token.startswith("  "):
            out += r"\quad "
        elif token == "^" and (power := re.compile(r"-\w+(/\w+)?").match(text, i)):
            i = power.end()
            out += "^{" + tex(power[0]) + "}"
        elif token == "^" and text.startswith("(", i):
            end = closing(text, i + 1)
            out += "^{" + tex(text[i + 1:end]) + "}"
            i = end + 1
        elif token in SIGNS:
            out += SIGNS[token]
        elif token in GREEK or token in FUNCTIONS:
            out += "\\" + token + " "
        elif token == "_" and (index := re.compile(r"[A-Za-z0-9]+").match(text, i)):
            i = index.end()
            out += "_{" + (tex(index[0]) if index[0] in GREEK + ["inf"] else index[0]) + "}"
        elif token == "_" and not text.startswith("{", i):
            out += r"\_"
        elif len(token) > 1 and token.isalpha():
            out += r"\text{ " + token + " }" if len(token) > 2 else r"\mathrm{" + token + "}"
        else:
            out += token
    out = re.sub(" {2,}", " ", out.strip())
    return re.sub(f"{WORD}(?: {WORD})+", lambda words: r"\text{ " + " ".join(re.findall("[A-Za-z]+(?= ?})", words[0])) + " }", out)


def is_prose(text):
    """Whether an indented line is a sentence: more words than signs of a formula."""
    return len(re.findall("[A-Za-z]{3,}", text)) > 5 * (1 + len(re.findall("[=^]", text)))


def comment_lines(lines):
    """The lines of one comment, without the slashes, in Doxygen's words."""
    out, in_heading = [], False
    for number, line in enumerate(lines):
        text = line.strip()
        indent = len(line) - len(line.lstrip(" "))
        heading = HEADING.match(text) if indent <= 1 else None
        after_text = number > 0 and lines[number - 1].strip()
        if heading:
            out += ["", f"@par {heading[1]}", heading[3]]
            in_heading = True
        elif not text:
            out.append("")
            in_heading = False
        elif indent >= 3 and not in_heading and (not after_text or out[-1].startswith(r"\f[")):
            out.append(text + "\n" if is_prose(text) else r"\f[" + tex(text) + r"\f]")
        else:
            out.append(text)
    return out


def filtered(source):
    out, block, margin = [], [], ""
    for line in source.splitlines() + [""]:
        match = re.match(r"(\s*)///(?!<)(.*)$", line)
        if match:
            block.append(match[2])
            margin = match[1]
            continue
        out += [f"{margin}/// {text}".rstrip() for text in comment_lines(block)]
        block = []
        out.append(line)
    return "\n".join(out[:-1]) + "\n"


def self_test():
    for given, wanted in {
        "sigma^2(m t) = 1/(2 m)": r"\sigma ^2(m t) = 1/(2 m)",
        "x_{n+2m} - x_n": "x_{n+2m} - x_{n}",
        "sqrt(a (b + c)) +- 2": r"\sqrt{a (b + c)} \pm 2",
        "(X' X)^-1 y": "(X' X)^{-1} y",
        "mean over all = 3": r"\text{ mean over all } = 3",
        "f = white": r"f = \text{ white }",
    }.items():
        assert tex(given) == wanted, (given, tex(given), wanted)
    page = filtered("/// Sum.\n///\n///   s = a + b\n///\n/// Given     a [u]\n///           b [u]\nint s();\n")
    assert r"/// \f[s = a + b\f]" in page and "/// @par Given\n/// a [u]\n/// b [u]\nint s();" in page, page
    assert filtered("int a;  ///< [m]\n") == "int a;  ///< [m]\n"


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        print("filter.py: passed")
    elif len(sys.argv) == 2:
        with open(sys.argv[1], encoding="utf-8") as file:
            text = file.read()
        sys.stdout.write(filtered(text) if sys.argv[1].endswith(".hpp") else text)
    else:
        sys.exit(__doc__)
