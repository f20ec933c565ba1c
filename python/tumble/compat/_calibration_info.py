"""The calibration of imucal as a value: matrices, units, JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from tumble import _tumble
from tumble._arrays import _array_of
from tumble._errors import DataError, FileError, UsageError, shown, wrong_type, wrong_value
from tumble._text import listed, need, path_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

FORMAT = "2.0.0"


@dataclass(eq=False)
class CalibrationInfo:
    """What every calibration has. `from_json` and the like give the class that the text names by `cal_type`."""

    CAL_FORMAT_VERSION: ClassVar[str] = FORMAT
    CAL_TYPE: ClassVar[str | None] = None
    _cal_paras: ClassVar[tuple[str, ...]] = ()
    acc_unit: str | None = None
    gyr_unit: str | None = None
    from_acc_unit: str | None = None
    from_gyr_unit: str | None = None
    comment: str | None = None

    def calibrate(
        self, acc: ArrayLike, gyr: ArrayLike, acc_unit: str | None, gyr_unit: str | None
    ) -> tuple[Array, Array]:
        """Calibrated accelerations and rates; defined by the class of the calibration."""
        raise NotImplementedError("this class of calibration defines no calibrate")

    def calibrate_df(
        self,
        df: Any,
        acc_unit: str | None,
        gyr_unit: str | None,
        acc_cols: Iterable[str] = ("acc_x", "acc_y", "acc_z"),
        gyr_cols: Iterable[str] = ("gyr_x", "gyr_y", "gyr_z"),
    ) -> Any:
        """A copy of a DataFrame with its six columns calibrated. Arguments as of calibrate."""
        if not hasattr(df, "columns") or not hasattr(df, "assign"):
            raise wrong_type("df", df, "accepted is a pandas DataFrame")
        accepted = f"accepted are columns of the DataFrame, which has {', '.join(map(str, df.columns))}"
        acc_names, gyr_names = listed(acc_cols, "acc_cols", accepted), listed(gyr_cols, "gyr_cols", accepted)
        for argument, names in (("acc_cols", acc_names), ("gyr_cols", gyr_names)):
            if any(not isinstance(name, Hashable) or name not in df.columns for name in names):
                raise wrong_value(argument, names, accepted)
        acc, gyr = self.calibrate(df[acc_names].to_numpy(), df[gyr_names].to_numpy(), acc_unit, gyr_unit)
        return df.assign(**dict(zip([*acc_names, *gyr_names], [*acc.T, *gyr.T], strict=True)))

    def _validate_units(self, acc: str | None, gyr: str | None) -> None:
        pairs = (("acc_unit", acc, self.from_acc_unit), ("gyr_unit", gyr, self.from_gyr_unit))
        problems = [
            f"argument {argument}: {shown(given)} was given; accepted is {own!r}, the unit that this calibration is for"
            for argument, given, own in pairs
            if not isinstance(given, (str, type(None))) or given != own
        ]
        if problems:
            raise UsageError(problems)

    def __eq__(self, other: object) -> bool:
        import numpy as np

        if not isinstance(other, self.__class__):
            raise TypeError(f"a {self.__class__.__name__} was compared with {other!r}")
        return fields(self) == fields(other) and all(
            np.array_equal(getattr(self, one.name), getattr(other, one.name)) for one in fields(self)
        )

    def _document(self) -> dict[str, Any]:
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        plain = {name: value.tolist() if hasattr(value, "tolist") else value for name, value in values.items()}
        return {**plain, "cal_type": self.CAL_TYPE, "_format_version": self.CAL_FORMAT_VERSION}

    def to_json(self) -> str:
        """The calibration as text, as imucal writes and reads it."""
        return json.dumps(self._document(), indent=4)

    def to_json_file(self, path: str | os.PathLike[str]) -> None:
        """Writes the text of to_json, whole or not at all."""
        _tumble.write_whole(path_text(path, "path"), self.to_json())

    def to_hdf5(self, path: str | os.PathLike[str]) -> None:
        """Writes the calibration as imucal does, with the package h5py."""
        text = path_text(path, "path")
        try:
            with need("h5py", "import").File(text, "w") as file:
                for name, value in self._document().items():
                    if name in self._cal_paras or value:
                        file[name] = value
        except OSError as error:
            raise FileError(f"{text}: {error}") from error

    @classmethod
    def from_json(cls, json_str: str) -> CalibrationInfo:
        """A calibration from the text of to_json, also of imucal's. Raises DataError with what is wrong."""
        try:
            document = json.loads(json_str)
        except TypeError as error:
            raise wrong_type("json_str", json_str, "accepted is the text of to_json") from error
        except (ValueError, RecursionError) as error:
            raise DataError(f"argument json_str: {error}") from error
        return cls._from_document(document)

    @classmethod
    def from_json_file(cls, path: str | os.PathLike[str]) -> CalibrationInfo:
        """A calibration from a file of to_json_file, also of imucal's. Raises FileError with what is wrong."""
        text = path_text(path, "path")
        try:
            return cls.from_json(Path(text).read_text(encoding="utf8"))
        except (OSError, UnicodeDecodeError, DataError) as error:
            raise _file_error(text, error) from error

    @classmethod
    def from_hdf5(cls, path: str | os.PathLike[str]) -> CalibrationInfo:
        """A calibration from a file of to_hdf5, also of imucal's."""
        text = path_text(path, "path")
        try:
            with need("h5py", "import").File(text, "r") as file:
                document = {name: one[()] for name, one in file.items()}
            return cls._from_document({k: v.decode() if isinstance(v, bytes) else v for k, v in document.items()})
        except (OSError, UnicodeDecodeError, TypeError, DataError) as error:  # TypeError: a group where data should be
            raise _file_error(text, error) from error

    @classmethod
    def _from_document(cls, document: Any) -> CalibrationInfo:
        import numpy as np

        values = dict(document) if isinstance(document, dict) else {}
        version = values.pop("_format_version", "1.0.0")
        if str(version) not in (FORMAT, "2.0"):
            raise DataError(f"format version {version!r} was given; accepted is {FORMAT}")
        found = cls.find_subclass_from_cal_type(values.pop("cal_type", None))
        known, wanted = {one.name for one in fields(found)}, found._cal_paras
        problems = [f"{name} is absent" for name in wanted if name not in values]
        problems += [f"{name} is not known; accepted are {', '.join(sorted(known))}" for name in set(values) - known]
        if problems:
            raise DataError(problems)
        arrays: dict[str, Any] = {name: np.array(one) if name in wanted else one for name, one in values.items()}
        return found(**arrays)

    @classmethod
    def _get_subclasses(cls) -> Iterator[type[CalibrationInfo]]:
        for subclass in cls.__subclasses__():
            yield from subclass._get_subclasses()
            yield subclass

    @classmethod
    def find_subclass_from_cal_type(cls, cal_type: str | None) -> type[CalibrationInfo]:
        """The class of calibrations of this type, this one or one made of it. Raises DataError."""
        classes = [cls, *cls._get_subclasses()]
        for one in classes:
            if cal_type == one.CAL_TYPE:
                return one
        known = ", ".join(one.CAL_TYPE for one in classes if one.CAL_TYPE)
        raise DataError(f"cal_type {cal_type!r} was given; accepted are {known}")


@dataclass(eq=False)
class FerrarisCalibrationInfo(CalibrationInfo):
    """The matrices of a Ferraris calibration, in units of the samples for 1 m/s^2 and 1 deg/s.

    K_a, K_g scale factors; R_a, R_g directions of the input axes; b_a, b_g biases; K_ga, what acceleration does to the
    gyros.
    """

    CAL_TYPE: ClassVar[str | None] = "Ferraris"
    _cal_paras: ClassVar[tuple[str, ...]] = ("K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g")
    acc_unit: str | None = "m/s^2"
    gyr_unit: str | None = "deg/s"
    K_a: Array = None  # type: ignore[assignment]
    R_a: Array = None  # type: ignore[assignment]
    b_a: Array = None  # type: ignore[assignment]
    K_g: Array = None  # type: ignore[assignment]
    R_g: Array = None  # type: ignore[assignment]
    K_ga: Array = None  # type: ignore[assignment]
    b_g: Array = None  # type: ignore[assignment]

    def calibrate(
        self, acc: ArrayLike, gyr: ArrayLike, acc_unit: str | None, gyr_unit: str | None
    ) -> tuple[Array, Array]:
        """Accelerations [acc_unit of this calibration] and rates [gyr_unit] of samples, each of shape (n, 3) or (3,).

        Given     acc, gyr            samples, rows at the same instants
                  acc_unit, gyr_unit  their units, which must be those that the calibration was made for
        Raises    UsageError for other units, shapes, and a calibration with a part missing
        """
        import numpy as np

        absent = [name for name in self._cal_paras if getattr(self, name, None) is None]
        if absent:
            raise UsageError(f"this calibration has no {', '.join(absent)}")
        self._validate_units(acc_unit, gyr_unit)
        part = {name: _floats(getattr(self, name), name) for name in self._cal_paras}
        force = _tumble.ferraris_calibrated(_triads(acc, "acc"), part["K_a"], part["R_a"], part["b_a"])
        rate = _tumble.ferraris_calibrated_rate(
            _triads(gyr, "gyr"), part["K_g"], part["R_g"], part["b_g"], part["K_ga"], force
        )
        return force.reshape(np.shape(acc)), rate.reshape(np.shape(gyr))


@dataclass(eq=False)
class TurntableCalibrationInfo(FerrarisCalibrationInfo):
    """The matrices of a calibration whose turns a table made."""

    CAL_TYPE: ClassVar[str | None] = "Turntable"


class AbsentFileError(FileError, FileNotFoundError):
    """There is no such file. It is a FileNotFoundError too, which imucal raises here."""


def _file_error(path: str, error: Exception) -> FileError:
    kind = AbsentFileError if isinstance(error, FileNotFoundError) else FileError
    return kind(f"{path}: {error}")


def _floats(values: Any, name: str) -> Array:
    import numpy as np

    array = np.ascontiguousarray(_array_of(values, name), dtype=np.float64)
    if array.shape != ((3,) if name.startswith("b_") else (3, 3)):
        raise UsageError(f"{name} has the shape {array.shape}; accepted are 3 by 3 for matrices and 3 for biases")
    return array


def _triads(values: Any, name: str) -> Array:
    import numpy as np

    array = np.atleast_2d(_array_of(values, name).astype(np.float64, copy=False))
    if array.ndim != 2 or array.shape[1] != 3:
        raise UsageError(f"argument {name}: an array of shape {array.shape} was given; accepted is the shape (n, 3)")
    return array
