"""Tumble: recordings of inertial instruments reduced to parameters with honest uncertainty.

    import tumble
    result = tumble.identify("allan_noise", "imu.csv")
    print(result)

Arrays that go in are shared without a copy where the type allows it. Every number that is returned has its unit beside
it.
"""

from tumble import _tumble

__version__: str = _tumble.version

# The module of each name. It is loaded when the name is first used: a program that computes an Allan deviation waits
# for nothing else. __init__.pyi says the same to type checkers.
_HOMES: dict[str, str] = {
    name: module
    for module, names in {
        "_allan": ("AllanDeviation", "allan_deviation"),
        "_catalogue": (
            "Catalogue",
            "Entry",
            "checks",
            "exports",
            "formats",
            "methods",
            "models",
            "plans",
            "rigs",
            "units",
        ),
        "_channel": ("Channel",),
        "_errors": (
            "ArgumentTypeError",
            "DataError",
            "FileError",
            "InternalError",
            "LimitError",
            "TumbleError",
            "TumbleWarning",
            "UsageError",
        ),
        "_figure": ("Figure",),
        "_finding": ("Finding",),
        "_from_pandas": ("from_pandas",),
        "_method": ("Coverage", "Method", "coverage"),
        "_plan": ("Plan", "load_plan"),
        "_read": ("from_arrays", "read"),
        "_recording": ("Mark", "Recording"),
        "_result": ("Result", "load_result"),
        "_result_parts": ("Covariance", "Curve", "Parameter", "Table", "Verdict"),
        "_tasks": (
            "compensate",
            "convert",
            "export",
            "identify",
            "optimise",
            "population",
            "predict",
            "report",
            "simulate",
            "validate",
        ),
    }.items()
    for name in names
}
_MODULES = ("archive", "compat", "fleet", "importers", "plot")
__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> object:
    if name not in _HOMES and name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES})
