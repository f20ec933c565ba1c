"""The check of the Chinese texts: no sentence of the program is untranslated. (check_web.py does the same for [web].)

  sections      [finding], [phrase], [certificate], [report], [terminal], [archive] and [list] have the keys of text/en.toml
  placeholders  a text has the placeholders of the English one, with the same formats. A noun,
                {lost:sample}, is {lost} in Chinese: the sentence has the counting word. Where English has one and other,
                Chinese has both or one text for both, with the placeholders of other
  translated    every text has a Han character, or is one of the few that need none
  typography    no half-width comma, semicolon, colon, question mark or parenthesis beside a Han character; no blank before
                a full-width mark; a blank between a Han character and a Latin letter or digit. No text has the plus-minus
                sign, which means an expanded uncertainty in Chinese, except where U stands beside it
  said          the key of a sentence in [said] consists of pieces that the sources say, and its text has each value of the
                key, numbered in order, except an ending as in "sample{}". The share of the sentences with which the sources refuse that
                have Chinese is printed, and must not fall below LEAST_SHARE: the others are said in English
  result        the words of a key in [result] stand in the sources, and its text has each value of the key
                (tests/chinese_results_test.cpp asks the other way: has every name and sentence of a result its Chinese?)
  verbs         every verb of apps/cli has its line in [verb]

    check_chinese.py REPOSITORY         exit 1 and one line a fault
    check_chinese.py --self-test        a sound small tree passes, and every kind of tampering with it is caught
"""

import re
import tomllib

import check_tools

LEAST_SHARE = 0.985  # of the sentences that refuse, those that have Chinese: it may only grow
SECTIONS = ["finding", "phrase", "certificate", "report", "terminal", "archive", "list"]
NEED_NO_HAN = {"finding.parameter_not_summarised", "phrase.axis_x", "phrase.axis_y", "report.next_pair", "report.findings_note",
               "certificate.coverage_factor", "certificate.colon", "certificate.comma", "certificate.rule_named",
               "certificate.ratio", "report.measured", "report.colon",
               "report.figure_caption", "report.figure_note", "report.next_source", "report.plot_next", "report.source_part",
               "report.table_caption", "terminal.measured_apart",
               "terminal.colon", "terminal.comma",
               "terminal.in_parentheses", "terminal.severity_before", "archive.comma", "archive.semicolon", "list.comma", "list.colon"}
PLACEHOLDER = re.compile(r"(?<!\{)\{(\w+)(?::([^}]*))?\}(?!\})")
WORDS = {"exact", "difference", "duration", "instant", "bytes"}
NOUN = re.compile(r"[a-z][a-z ]*$")
HAN = r"\u4e00-\u9fff"
TYPOGRAPHY = {
    "a half-width mark beside a Han character": re.compile(rf"[{HAN}][,;:?!()]|[,;:?!(][{HAN}]"),
    "a blank before a full-width mark": re.compile(r" [，。；：？！）、”]"),
    "no blank between Han and Latin": re.compile(rf"[{HAN}][A-Za-z0-9]|[A-Za-z0-9][{HAN}]"),
    "a plus-minus sign": re.compile(r"\+-|±(?! U)"),
}
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"\((.*?)\)"|"((?:[^"\\\n]|\\.)*)"|\'(?:[^\'\\\n]|\\.)+\'', re.DOTALL)
REFUSES = re.compile(r"throw|Error[({]|problem|refus|complain|\bfail\(|missing\.push|\bsay\($|\badd\($")
VERB = re.compile(r'Verb \w+_verb\([^)]*\) \{.*?return \{\s*"([a-z-]+)"', re.DOTALL)


def places_of(text):
    return {(name, "" if how not in WORDS and NOUN.match(how) else how) for name, how in PLACEHOLDER.findall(text)}


def pairs_of(english, chinese):
    """Texts that say the same: (name of the form, English, Chinese)."""
    if not isinstance(english, dict):
        return [("", english, chinese)]
    if not isinstance(chinese, dict):
        return [("", english["other"], chinese)]
    return [("." + form, english[form], chinese.get(form, "")) for form in english]


def faults_of_typography(key, chinese):
    return [f"text/zh.toml: {key} has {what}: '{match[0]}'" for what, pattern in TYPOGRAPHY.items()
            if (match := pattern.search(PLACEHOLDER.sub("·", chinese) if "mark" in what else chinese))]


def faults_of_text(key, english, chinese):
    faults = []
    missing, more = places_of(english) - places_of(chinese), places_of(chinese) - places_of(english)
    if missing or more:
        names = sorted(name + (":" + how if how else "") for name, how in missing | more)
        faults.append(f"text/zh.toml: {key} has other placeholders than the English text: {', '.join(names)}")
    if english and not re.search(f"[{HAN}]", chinese) and key.removesuffix(".one").removesuffix(".other") not in NEED_NO_HAN:
        faults.append(f"text/zh.toml: {key} is not translated: '{chinese}'")
    return faults + faults_of_typography(key, chinese)


def faults_of_sections(english, chinese):
    faults = []
    for section in SECTIONS:
        ours, theirs = english.get(section, {}), chinese.get(section, {})
        faults += [f"text/zh.toml: [{section}] lacks {key}" for key in sorted(ours.keys() - theirs.keys())]
        faults += [f"text/en.toml: [{section}] lacks {key}" for key in sorted(theirs.keys() - ours.keys())]
        for key in sorted(ours.keys() & theirs.keys()):
            for form, one, other in pairs_of(ours[key], theirs[key]):
                faults += faults_of_text(f"{section}.{key}{form}", one, other)
    return faults


def faults_of_verbs(root, chinese):
    texts = [path.read_text(encoding="utf-8") for path in sorted((root / "apps/cli").glob("*.cpp"))]
    names = {name for text in texts for name in VERB.findall(text)}
    faults = [f"text/zh.toml: [verb] lacks {name}" for name in sorted(names - chinese.get("verb", {}).keys())]
    return faults + [f"apps/cli: there is no verb {name} of [verb]" for name in sorted(chinese.get("verb", {}).keys() - names)]


def pieces_of(key):
    """What stands around the values of a sentence; two values side by side are one."""
    return re.sub(r"(?<!\{)(?:\{[^{}]*\})+(?!\})", "\0", key).replace("{{", "{").replace("}}", "}").split("\0")


def literals_of(text):
    """Strings of C++, those side by side as one, each with what stands before it in its statement."""
    found, end = [], 0
    for token in TOKEN.finditer(text):
        if token[0][0] in "/'":
            continue
        said = token[1]
        if said is None:
            said = re.sub(r"\\(.)", lambda one: {"n": "\n", "t": "\t"}.get(one[1], one[1]), token[2])
        if found and not text[end:token.start()].strip():
            found[-1] = (found[-1][0] + said, found[-1][1])
        else:
            found.append((said, text[max(text.rfind(";", 0, token.start()), 0):token.start()]))
        end = token.end()
    return found


def sentences_of_sources(root):
    """Every string of the sources and every title of a plan, and the strings with which the sources refuse."""
    every, refusals = [], set()
    for folder in ("tumble", "apps"):
        for path in sorted((root / folder).rglob("*.[ch]pp")):
            if path.stem.endswith("_test") or "testing" in path.parts:
                continue
            for said, before in literals_of(path.read_text(encoding="utf-8")):
                every.append(said)
                if REFUSES.search(before) and len(re.findall(r"(?<![^ (\"'])[A-Za-z]{2,}", " ".join(pieces_of(said)))) > 2:
                    refusals.add(said)
    titles = [line for path in sorted((root / "plans").glob("*.toml")) for line in path.read_text(encoding="utf-8").splitlines()
              if line.startswith("title")]
    return every + titles, refusals


def key_of(pattern):
    """The pattern as language/said.cpp looks it up: each value, or several side by side, as {}."""
    return re.sub(r"(?<!\{)(?:\{[^{}]*\})+(?!\})", "{}", pattern)


def has_chinese(key, keys):
    """Whether a pattern has its Chinese: as a whole or line by line, or what stands before and behind one of its colons."""
    if "\n" in key:
        return all(has_chinese(line.strip(" "), keys) for line in key.split("\n"))
    if key in keys or not re.search("[A-Za-z]", key):
        return True
    return any(has_chinese(key[:at.start()], keys) and has_chinese(key[at.end():], keys) for at in re.finditer(": ", key))


def is_said(piece, sources):
    """Whether the sources say the clauses of a piece; one word at either end may be a value of the source."""
    for clause in re.split(r"[^\w /*.<>=-]+", piece):
        words = clause.split()
        if not any(" ".join(some) in sources for some in (words, words[1:], words[:-1])):
            return False
    return True


def faults_of_values(section, key, text):
    """Each value of the key stands in its text, except an ending as in "sample{}"."""
    values = {int(value) for value in re.findall(r"\{(\d+)\}", text)}
    pieces = pieces_of(key)
    plural = {k for k, piece in enumerate(pieces[:-1]) if section != "result" and piece[-1:].isalpha()}
    faults = faults_of_typography(f"{section}.'{key}'", text)
    if values | plural != set(range(len(pieces) - 1)) | plural:
        faults.append(f"text/zh.toml: {section}.'{key}' has other values than its key: {text}")
    return faults


def faults_of_said(root, chinese):
    every, refusals = sentences_of_sources(root)
    sources = " ".join(" ".join(" ".join(pieces_of(said)) for said in every).split())
    words = set(re.findall(r"[A-Za-z]+", sources + (root / "text/en.toml").read_text(encoding="utf-8")))
    words.update(word for path in (root / "tumble").rglob("*.cpp") for word in path.stem.split("_"))
    faults, spoken = [], set()
    for key, text in chinese.get("said", {}).items():
        pieces = pieces_of(key)
        faults += [f"text/zh.toml: said.'{key}': no source says '{piece}'" for piece in pieces if not is_said(piece, sources)]
        spoken.update(piece.strip() for piece in pieces)
    looked_up = {}
    for key in chinese.get("result", {}):
        if (other := looked_up.setdefault(key.replace("_", " "), key)) != key:
            faults.append(f"text/zh.toml: result.'{key}' is the same as '{other}': names are looked up without underscores")
        faults += [f"text/zh.toml: result.'{key}': no source says '{word}'"
                   for piece in pieces_of(key) for word in re.findall(r"[A-Za-z]+", piece) if word not in words]
    for section in ("said", "said_by_libraries", "result"):
        for key, text in chinese.get(section, {}).items():
            faults += faults_of_values(section, key, text)
    keys = {key_of(key) for section in ("said", "said_by_libraries") for key in chinese.get(section, {})}
    # Words without values stand with their braces as they are: in a pattern these are doubled.
    done = sum(has_chinese(key_of(said), keys) or said.replace("{", "{{").replace("}", "}}") in keys for said in refusals)
    if done < LEAST_SHARE * len(refusals):
        faults.append(f"tests/check_chinese.py: {done} of {len(refusals)} sentences that refuse have Chinese, fewer than {LEAST_SHARE:.1%}")
    return faults, f"{done} of {len(refusals)} sentences that refuse ({done / max(len(refusals), 1):.1%}) have Chinese"


def check(root):
    english, chinese = (tomllib.loads((root / f"text/{code}.toml").read_text(encoding="utf-8")) for code in ("en", "zh"))
    faults, told = faults_of_said(root, chinese)
    return faults_of_sections(english, chinese) + faults_of_verbs(root, chinese) + faults, told


SOUND_ENGLISH = ('[finding]\ngap.one = "{lost:sample} lost at {first}"\ngap.other = "{lost:sample} lost, most at {worst}"\n'
                 'slow = "{length:duration}"\n')
SOUND_CHINESE = ('[finding]\ngap = "丢失 {lost} 个采样点，最多在 {worst}"\nslow = "长 {length:duration}"\n[verb]\nlist = "列出"\n'
                 '[said]\n"no file {}, {}" = "没有文件 {0}、{1}"\n[result]\n"file over {}" = "文件随 {0}"\n')
SOUND = {
    "text/en.toml": SOUND_ENGLISH,
    "text/zh.toml": SOUND_CHINESE,
    "apps/cli/list.cpp": 'Verb list_verb() {\n  auto a = 1;\n  return {"list",\n "List"};\n}\n',
    "tumble/core/find.cpp": 'throw Error("no file {}"\n ", {}");\n say("file over {}");\n',
}


def changed(old, new):
    return "text/zh.toml", SOUND_CHINESE.replace(old, new)


TAMPERED = {
    "a key without Chinese": (*changed('slow = "长 {length:duration}"\n', ""), "lacks slow"),
    "a key without English": (*changed("[verb]", 'fast = "快"\n[verb]'), "lacks fast"),
    "another placeholder": (*changed("{worst}", "{first}"), "other placeholders than the English text: first, worst"),
    "another format": (*changed("{length:duration}", "{length}"), "other placeholders"),
    "English among Chinese": (*changed("长 {length:duration}", "{length:duration} long"), "not translated"),
    "half of a pair": (*changed('gap = "丢失 {lost} 个采样点，最多在 {worst}"', 'gap.one = "在 {first} 丢失 {lost} 个采样点"\n'
                                'gap.other = "丢失 {lost} 个采样点"'), "gap.other has other placeholders"),
    "a half-width comma": (*changed("，", ","), "a half-width mark"),
    "a word without its blank": (*changed("长 {", "长x {"), "no blank between"),
    "a plus-minus sign": (*changed("长 {", "长 ± {"), "a plus-minus sign"),
    "a sentence that nothing says": (*changed("no file {}", "no such file {}"), "no source says 'no such file '"),
    "a value that is lost": (*changed("{0}、{1}", "{1}"), "other values than its key"),
    "a word that nothing says": (*changed("file over", "folder over"), "no source says 'folder'"),
    "a name that is there twice": (*changed('"file over {}" =', '"file_over {}" = "文件随 {0}"\n"file over {}" ='), "is the same as"),
    "a value of a result that is lost": (*changed("文件随 {0}", "文件"), "other values than its key"),
    "a verb without its line": ("apps/cli/init.cpp", 'Verb init_verb() {\n  return {"init", "Write"};\n}\n', "[verb] lacks init"),
    "a refusal without Chinese": ("tumble/core/write.cpp", 'throw Error("there is no room");\n', "0 of 1 sentences that refuse have Chinese"),
    "a line without its verb": (*changed("[verb]", '[verb]\ninit = "写"'), "no verb init"),
}


if __name__ == "__main__":
    check_tools.main(__doc__, check, lambda: check_tools.faults_of_tampering(lambda root: check(root)[0], SOUND, TAMPERED),
                     "every sentence of the program is there in Chinese")
