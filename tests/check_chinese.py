"""The check of the Chinese texts: no sentence of the program is untranslated. (check_web.py does the same for [web].)

  sections      [finding], [phrase], [certificate], [report], [terminal], [archive] and [list] have the keys of text/en.toml
  placeholders  a text has the placeholders of the English one, with the same formats. A noun,
                {lost:sample}, is {lost} in Chinese: the sentence has the counting word. Where English has one and other,
                Chinese has both or one text for both, with the placeholders of other
  translated    every text has a Han character, or is one of the few that need none
  typography    no half-width comma, semicolon, colon, question mark or parenthesis beside a Han character; no blank before
                a full-width mark; a blank between a Han character and a Latin letter or digit. No text has the plus-minus
                sign, which means an expanded uncertainty in Chinese, except where U stands beside it
  verbs         every verb of apps/cli has its line in [verb]

    check_chinese.py REPOSITORY         exit 1 and one line a fault
    check_chinese.py --self-test        a sound small tree passes, and every kind of tampering with it is caught
"""

import re
import tomllib

import check_tools

SECTIONS = ["finding", "phrase", "certificate", "report", "terminal", "archive", "list"]
NEED_NO_HAN = {"finding.parameter_not_summarised", "phrase.axis_x", "phrase.axis_y", "report.next_pair", "report.findings_note",
               "certificate.coverage_factor", "certificate.ratio", "report.measured", "terminal.measured_apart",
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


def faults_of_text(key, english, chinese):
    faults = []
    missing, more = places_of(english) - places_of(chinese), places_of(chinese) - places_of(english)
    if missing or more:
        names = sorted(name + (":" + how if how else "") for name, how in missing | more)
        faults.append(f"text/zh.toml: {key} has other placeholders than the English text: {', '.join(names)}")
    if english and not re.search(f"[{HAN}]", chinese) and key.removesuffix(".one").removesuffix(".other") not in NEED_NO_HAN:
        faults.append(f"text/zh.toml: {key} is not translated: '{chinese}'")
    return faults + [f"text/zh.toml: {key} has {what}: '{match[0]}'" for what, pattern in TYPOGRAPHY.items()
                     if (match := pattern.search(PLACEHOLDER.sub("·", chinese) if "mark" in what else chinese))]


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


def check(root):
    english, chinese = (tomllib.loads((root / f"text/{code}.toml").read_text(encoding="utf-8")) for code in ("en", "zh"))
    return faults_of_sections(english, chinese) + faults_of_verbs(root, chinese)


SOUND_ENGLISH = ('[finding]\ngap.one = "{lost:sample} lost at {first}"\ngap.other = "{lost:sample} lost, most at {worst}"\n'
                 'slow = "{length:duration}"\n')
SOUND_CHINESE = '[finding]\ngap = "丢失 {lost} 个采样点，最多在 {worst}"\nslow = "长 {length:duration}"\n[verb]\nlist = "列出"\n'
SOUND = {
    "text/en.toml": SOUND_ENGLISH,
    "text/zh.toml": SOUND_CHINESE,
    "apps/cli/list.cpp": 'Verb list_verb() {\n  auto a = 1;\n  return {"list",\n "List"};\n}\n',
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
    "a verb without its line": ("apps/cli/init.cpp", 'Verb init_verb() {\n  return {"init", "Write"};\n}\n', "[verb] lacks init"),
    "a line without its verb": (*changed("[verb]", '[verb]\ninit = "写"'), "no verb init"),
}


if __name__ == "__main__":
    check_tools.main(__doc__, lambda root: (check(root), ""), lambda: check_tools.faults_of_tampering(check, SOUND, TAMPERED),
                     "every sentence of the program is there in Chinese")
