"""What `import tumble` offers, for type checkers and editors; __init__.py loads it when it is first used."""

from tumble import archive as archive
from tumble import compat as compat
from tumble import fleet as fleet
from tumble import importers as importers
from tumble import plot as plot
from tumble._allan import AllanDeviation, allan_deviation
from tumble._catalogue import Catalogue, Entry, checks, exports, formats, methods, models, plans, rigs, units
from tumble._channel import Channel
from tumble._errors import (
    ArgumentTypeError,
    DataError,
    FileError,
    InternalError,
    LimitError,
    TumbleError,
    TumbleWarning,
    UsageError,
)
from tumble._figure import Figure
from tumble._finding import Finding
from tumble._from_pandas import from_pandas
from tumble._method import Coverage, Method, coverage
from tumble._plan import Plan, load_plan
from tumble._read import from_arrays, read
from tumble._recording import Mark, Recording
from tumble._result import Result, load_result
from tumble._result_parts import Covariance, Curve, Parameter, Table, Verdict
from tumble._tasks import (
    compensate,
    convert,
    export,
    identify,
    optimise,
    population,
    predict,
    report,
    simulate,
    validate,
)

__version__: str

__all__ = [
    "AllanDeviation",
    "ArgumentTypeError",
    "Catalogue",
    "Channel",
    "Covariance",
    "Coverage",
    "Curve",
    "DataError",
    "Entry",
    "Figure",
    "FileError",
    "Finding",
    "InternalError",
    "LimitError",
    "Mark",
    "Method",
    "Parameter",
    "Plan",
    "Recording",
    "Result",
    "Table",
    "TumbleError",
    "TumbleWarning",
    "UsageError",
    "Verdict",
    "__version__",
    "allan_deviation",
    "checks",
    "compensate",
    "convert",
    "coverage",
    "export",
    "exports",
    "formats",
    "from_arrays",
    "from_pandas",
    "identify",
    "load_plan",
    "load_result",
    "methods",
    "models",
    "optimise",
    "plans",
    "population",
    "predict",
    "read",
    "report",
    "rigs",
    "simulate",
    "units",
    "validate",
]
