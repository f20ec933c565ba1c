"""The layer check: every include in tumble/ goes to the left in tumble/layers.txt.

Headers that stand directly in a module are its face: they name no heavy library. Headers in a subfolder of a module are
its own business: nothing outside of the module, and no header of its face, includes them. Only those that help with a
heavy library (math/eigen/) serve the .cpp files and subfolders of all modules to the right.

    check_layers.py REPOSITORY      exit 1 and one line a fault
    check_layers.py --self-test     a sound small tree passes, and every kind of tampering with it is caught
"""

import pathlib
import re
import sys
import tempfile

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
GENERATED = {"tumble/version.hpp"}
SHARED = ("tumble/math/eigen/",)  # between our types and a heavy library
# Heavy libraries: a header that names one makes every file that includes it pay, and ties our interface to theirs.
HEAVY = ("Eigen/", "nlohmann/", "toml++/", "boost/", "hdf5", "H5", "openssl/", "nlopt", "CLI/")


def fault_of_include(layer, layers, quoted, target, is_face):
    """What is wrong with one include of a file in `layer`, or None."""
    if is_face and not quoted and target.startswith(HEAVY):
        return f"header includes <{target}>: keep it in the .cpp"
    if target.startswith("apps/"):
        return f'includes "{target}": the library knows no front end'
    if not target.startswith("tumble/"):
        return f'includes "{target}": write our own headers from the root ("tumble/...")' if quoted else None
    if target in GENERATED:
        return None
    other, internal = target.split("/")[1], target.count("/") > 2
    if other not in layers:
        return f'includes "{target}": {other} is not in tumble/layers.txt'
    if layers.index(other) > layers.index(layer):
        return f'includes "{target}": {layer} stands before {other} in tumble/layers.txt'
    if internal and (is_face or (other != layer and not target.startswith(SHARED))):
        return f'includes "{target}": headers in a subfolder are internal to {other}'
    return None


def check(root):
    """All faults of the tree under `root`, as lines 'file:line: what'."""
    layers = (root / "tumble/layers.txt").read_text().split()
    files = sorted(p for p in (root / "tumble").rglob("*") if p.suffix in (".hpp", ".cpp"))
    faults = [] if files else [f"{root}/tumble: no source file found"]
    for path in files:
        relative = path.relative_to(root)
        layer = relative.parts[1]
        if layer not in layers:
            faults.append(f"{relative}: {layer} is not in tumble/layers.txt")
            continue
        is_face = path.suffix == ".hpp" and len(relative.parts) == 3
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            fault = fault_of_include(layer, layers, match[1] == '"', match[2], is_face)
            if fault:
                faults.append(f"{relative}:{number}: {fault}")
    return faults


SOUND = {
    "tumble/layers.txt": "units\nmath\ncore\n",
    "tumble/units/unit.hpp": "#pragma once\n#include <string>\n",
    "tumble/math/fit.hpp": '#pragma once\n#include "tumble/units/unit.hpp"\n',
    "tumble/math/fit.cpp": '#include "tumble/math/fit.hpp"\n#include <Eigen/Dense>\n#include "tumble/version.hpp"\n',
    "tumble/core/part/deep.cpp": '#include "tumble/math/fit.hpp"\n#include "tumble/core/part/deep.hpp"\n',
    "tumble/core/part/deep.hpp": '#include <hdf5.h>\n#include "tumble/math/eigen/view.hpp"\n',
    "tumble/core/shared.cpp": '#include "tumble/math/eigen/view.hpp"\n',
    "apps/cli/main.cpp": '#include "tumble/core/any.hpp"\n#include "apps/cli/verbs.hpp"\n',
}
TAMPERED = {  # file, its new text, words of the fault
    "climbs": ("tumble/units/unit.hpp", '#include "tumble/math/fit.hpp"\n', "units stands before math"),
    "climbs from a subfolder": ("tumble/math/a/b.cpp", ' #  include "tumble/core/any.hpp"\n', "math stands before core"),
    "climbs in angle brackets": ("tumble/units/unit.hpp", "#include <tumble/core/any.hpp>\n", "units stands before core"),
    "knows a front end": ("tumble/core/x.cpp", '#include "apps/cli/verbs.hpp"\n', "no front end"),
    "Eigen in a header": ("tumble/math/fit.hpp", "#include <Eigen/Core>\n", "keep it in the .cpp"),
    "nlohmann in a header": ("tumble/core/x.hpp", "#include <nlohmann/json.hpp>\n", "keep it in the .cpp"),
    "toml++ in a header": ("tumble/core/x.hpp", "#include <toml++/toml.h>\n", "keep it in the .cpp"),
    "HDF5 in a header": ("tumble/core/x.hpp", "#include <hdf5.h>\n", "keep it in the .cpp"),
    "relative include": ("tumble/math/fit.cpp", '#include "fit.hpp"\n', "from the root"),
    "internal header of another module": ("tumble/core/x.cpp", '#include "tumble/math/a/b.hpp"\n', "internal to math"),
    "Eigen's view in a face": ("tumble/core/x.hpp", '#include "tumble/math/eigen/view.hpp"\n', "internal to math"),
    "internal header in a face": ("tumble/core/x.hpp", '#include "tumble/core/part/deep.hpp"\n', "internal to core"),
    "unlisted module": ("tumble/extra/x.cpp", "\n", "extra is not in"),
    "include of an unlisted module": ("tumble/core/x.cpp", '#include "tumble/extra/x.hpp"\n', "extra is not in"),
    "nothing there": (None, None, "no source file"),
}


def self_test():
    def faults_with(change):
        tree = dict(SOUND)
        if change:
            name, text, _ = change
            tree = {"tumble/layers.txt": "units\n"} if name is None else {**tree, name: text}
        with tempfile.TemporaryDirectory() as folder:
            for name, text in tree.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return check(pathlib.Path(folder))

    failures = [f"the sound tree is refused: {fault}" for fault in faults_with(None)]
    for name, change in TAMPERED.items():
        faults = faults_with(change)
        if len(faults) != 1 or change[2] not in faults[0]:
            failures.append(f"tampered tree '{name}' gives {faults}, expected one fault with '{change[2]}'")
    return failures


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    faults = self_test() if sys.argv[1] == "--self-test" else check(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(faults) if faults else "layer check passed")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
