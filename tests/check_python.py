"""The check of the Python package: no modules of python/tumble import each other, directly or through others.

An import in a function counts, and one for type checkers too. What is loaded by its name (the names of the package when
they are first used, the importers) is not imported.

    check_python.py REPOSITORY      exit 1 and one line a fault
    check_python.py --self-test     a sound small tree passes, and every kind of tampering with it is caught
"""

import ast

import check_tools


def name_of(path, root):
    """The name of a module, as an import writes it."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(name, path, modules):
    """The modules that a module imports anywhere in its text. modules: {name: path} of the package."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            inner = (f"{base}.{alias.name}" for alias in node.names)
            found |= {one if one in modules else base for one in inner}
    return found & modules.keys() - {name}


def check(root):
    modules = {name_of(path, root / "python"): path for path in sorted((root / "python/tumble").rglob("*.py"))}
    circles = check_tools.circles({name: imports_of(name, path, modules) for name, path in modules.items()})
    return [f"python/tumble: {', '.join(circle)} import each other" for circle in circles] \
        + ([] if modules else ["python/tumble: no module found"])


SOUND = {
    "python/tumble/__init__.py": "from tumble import _tumble\n",
    "python/tumble/_text.py": "from __future__ import annotations\nfrom tumble import _tumble\n",
    "python/tumble/_read.py": "def read():\n    from tumble._text import need\n    import numpy\n",
    "python/tumble/_result.py": "import tumble\nfrom tumble import _read\nif TYPE_CHECKING:\n    from tumble.fleet import Fleet\n",
    "python/tumble/fleet/__init__.py": "from tumble.fleet._run import run\n",
    "python/tumble/fleet/_run.py": "from .. import _text\nfrom . import _store\nfrom .._read import read\n",
    "python/tumble/fleet/_store.py": "import json\n",
}
TAMPERED = {
    "a circle of two": ("python/tumble/_text.py", "from tumble._read import read\n", "tumble._read, tumble._text import each other"),
    "in a function": ("python/tumble/_text.py", "def f():\n    from tumble import _read\n", "tumble._read, tumble._text import"),
    "for type checkers": ("python/tumble/_text.py", "if TYPE_CHECKING:\n    import tumble._read\n", "tumble._read, tumble._text import"),
    "through others": ("python/tumble/fleet/_store.py", "from tumble._result import Result\n",
                       "tumble._result, tumble.fleet, tumble.fleet._run, tumble.fleet._store import each other"),
    "a relative import": ("python/tumble/fleet/_store.py", "from ._run import run\n", "tumble.fleet._run, tumble.fleet._store import"),
    "a module and its package": ("python/tumble/fleet/_store.py", "from tumble.fleet import run\n",
                                 "tumble.fleet, tumble.fleet._run, tumble.fleet._store import each other"),
}


def self_test():
    with check_tools.tree_of({"python/README.md": ""}) as root:
        empty = check(root)
    return check_tools.faults_of_tampering(check, SOUND, TAMPERED) \
        + ([] if empty == ["python/tumble: no module found"] else [f"a tree without modules gives {empty}"])


if __name__ == "__main__":
    check_tools.main(__doc__, lambda root: (check(root), ""), self_test, "no modules of the Python package import each other")
