"""What the checks of the tree share: a tree of files to try them on, their self-test, their command line."""

import contextlib
import pathlib
import sys
import tempfile


@contextlib.contextmanager
def tree_of(files):
    """A folder with these files, {name: text}, until the end of the block."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        yield pathlib.Path(folder)


def faults_of_tampering(faults_of, sound, tampered):
    """Faults of a check: the sound tree must pass, and every tampering give one fault with its words.

    faults_of: takes a folder, returns its faults. tampered: {name: (file, its new text, words of the fault)}.
    """
    with tree_of(sound) as root:
        failures = [f"the sound tree is refused: {fault}" for fault in faults_of(root)]
    for name, (path, text, words) in tampered.items():
        with tree_of({**sound, path: text}) as root:
            faults = faults_of(root)
        if len(faults) != 1 or words not in faults[0]:
            failures.append(f"tampered tree '{name}' gives {faults}, expected one fault with '{words}'")
    return failures


def reached(imports, first):
    """Everything that an entry imports, directly or through others. imports: {entry: set of entries}."""
    found, waiting = set(), [first]
    while waiting:
        for one in imports.get(waiting.pop(), ()):
            if one not in found:
                found.add(one)
                waiting.append(one)
    return found


def circles(imports):
    """Groups of entries that import each other, each sorted. imports: {entry: set of entries}."""
    reach = {entry: reached(imports, entry) for entry in imports}
    groups = {tuple(sorted(other for other in reach if other in reach[entry] and entry in reach[other]))
              for entry in imports if entry in reach[entry]}
    return sorted(groups)


def main(doc, check, self_test, passed):
    """`check_x.py REPOSITORY` or `--self-test`: exit 1 and one line a fault. check: takes the root, returns (faults,
    report); the report is printed before them."""
    if len(sys.argv) != 2:
        sys.exit(doc)
    is_test = sys.argv[1] == "--self-test"
    faults, report = (self_test(), "") if is_test else check(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(([report] if report else []) + (faults or [passed])))
    sys.exit(1 if faults else 0)
