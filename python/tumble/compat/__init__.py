"""Modules with the names, arguments and answers of other packages, calculated by Tumble.

`tumble.compat.allantools` replaces AllanTools 2024.6, `tumble.compat.imucal` replaces imucal 2.6.
"""

_MODULES = ("allantools", "imucal")


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
