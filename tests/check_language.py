"""The check of a file of texts in any language, complete or begun (docs/adding/language.md).

  keys          each text has the key of a text in text/en.toml
  placeholders  and the placeholders of the English one, with the same formats. A noun, {lost:sample}, is {lost}: the
                sentence has the counting word

It prints how many texts of each section the language has.

    check_language.py REPOSITORY FILE   exit 1 and one line a fault
    check_language.py --self-test       a sound file passes, and every kind of tampering with it is caught
"""

import pathlib
import re
import sys
import tomllib

from check_chinese import pairs_of, places_of
from check_tools import faults_of_tampering

NUMBERED = re.compile(r"\{(\d+)\}")


def places(text):
    return places_of(text) | {(number, "") for number in NUMBERED.findall(text)}


def faults_of(english, language, name):
    faults = []
    for section, texts in language.items():
        faults += [f"{name}: [{section}] {key} stands in no text of text/en.toml" for key in texts
                   if key not in english.get(section, {})]
        for key in texts.keys() & english.get(section, {}).keys():
            for form, ours, theirs in pairs_of(english[section][key], texts[key]):
                if different := sorted(place for place, how in places(ours) ^ places(theirs)):
                    faults.append(f"{name}: {section}.{key}{form} has other placeholders: {', '.join(different)}")
    return sorted(faults)


def check(root, file):
    english, language = (tomllib.loads(path.read_text(encoding="utf-8")) for path in (root / "text/en.toml", file))
    report = [f"[{section}] {len(language.get(section, {}))} of {len(english[section])}" for section in english]
    return faults_of(english, language, file.name), report


ENGLISH = '[finding]\ngap.one = "{lost:sample} lost"\ngap.other = "{count} gaps"\n[certificate]\npage = "page {0}"\n'
SOUND = {"text/en.toml": ENGLISH, "de.toml": '[finding]\ngap.one = "{lost} fehlt"\ngap.other = "{count} Lücken"\n'
                                            '[certificate]\npage = "Seite {0}"\n'}
TAMPERED = {
    "a key that English lacks": ("de.toml", '[certificate]\nleaf = "Blatt"\n', "[certificate] leaf stands in no text"),
    "a section that English lacks": ("de.toml", '[pages]\npage = "Seite"\n', "[pages] page stands in no text"),
    "a value that is lost": ("de.toml", '[certificate]\npage = "Seite"\n', "certificate.page has other placeholders: 0"),
    "another value": ("de.toml", '[finding]\ngap = "{counted} Lücken"\n', "finding.gap has other placeholders: count, counted"),
}


def main():
    if sys.argv[1:] == ["--self-test"]:
        faults = faults_of_tampering(lambda root: check(root, root / "de.toml")[0], SOUND, TAMPERED)
    elif len(sys.argv) == 3:
        faults, report = check(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve())
        print("\n".join(report))
    else:
        sys.exit(__doc__)
    print("\n".join(faults or ["language check passed"]))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
