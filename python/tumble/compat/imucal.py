"""The Ferraris calibration of imucal 2.6 with its classes, arguments and JSON, calculated by Tumble.

    from tumble.compat.imucal import FerrarisCalibration, ferraris_regions_from_df
    regions = ferraris_regions_from_df(df)
    cal = FerrarisCalibration().compute(regions, 204.8, from_acc_unit="a.u.", from_gyr_unit="a.u.")
    acc, gyr = cal.calibrate(acc, gyr, "a.u.", "a.u.")

The answer has no uncertainty; `tumble.identify("imu_ferraris", ...)` gives the same matrices with theirs.
docs/imucal.md has more on the differences.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from tumble import _tumble
from tumble._arrays import _array_of
from tumble._errors import DataError, UsageError, wrong_type, wrong_value
from tumble._text import listed, number_of
from tumble.compat._calibration_folder import (
    CalibrationWarning,
    find_calibration_info_for_sensor,
    find_closest_calibration_info_to_date,
    load_calibration_info,
    save_calibration_info,
)
from tumble.compat._calibration_info import CalibrationInfo, FerrarisCalibrationInfo, TurntableCalibrationInfo

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Samples = NDArray[np.float64]

__all__ = [
    "CalibrationInfo",
    "CalibrationWarning",
    "FerrarisCalibration",
    "FerrarisCalibrationInfo",
    "FerrarisSignalRegions",
    "TurntableCalibration",
    "TurntableCalibrationInfo",
    "ferraris_regions_from_df",
    "ferraris_regions_from_section_list",
    "find_calibration_info_for_sensor",
    "find_closest_calibration_info_to_date",
    "load_calibration_info",
    "save_calibration_info",
]

ACC = ("acc_x", "acc_y", "acc_z")
GYR = ("gyr_x", "gyr_y", "gyr_z")


class FerrarisSignalRegions(NamedTuple):
    """The samples of each section, shape (n, 3), of the accelerometers and of the gyros."""

    acc_x_p: Samples
    acc_x_a: Samples
    acc_y_p: Samples
    acc_y_a: Samples
    acc_z_p: Samples
    acc_z_a: Samples
    gyr_x_p: Samples
    gyr_x_a: Samples
    gyr_y_p: Samples
    gyr_y_a: Samples
    gyr_z_p: Samples
    gyr_z_a: Samples
    acc_x_rot: Samples
    acc_y_rot: Samples
    acc_z_rot: Samples
    gyr_x_rot: Samples
    gyr_y_rot: Samples
    gyr_z_rot: Samples

    def validate(self) -> None:
        """Raises ValueError for a section without samples or of another type."""
        for name, values in self._asdict().items():
            _region(values, name)


class FerrarisCalibration:
    """The matrices of accelerometers and gyros from six poses and three turns (docs/methods/imu_ferraris.md).

    Given     grav                    [m/s^2], positive where an axis that points up shows +1 g
              expected_angle          [deg] of each turn, negative for clockwise
              calibration_info_class  class of the answer
    """

    OUT_ACC_UNIT: ClassVar[str] = "m/s^2"
    OUT_GYR_UNIT: ClassVar[str] = "deg/s"
    FERRARIS_SECTIONS: ClassVar[tuple[str, ...]] = (
        *("x_p", "x_a", "y_p", "y_a", "z_p", "z_a"),
        *("x_rot", "y_rot", "z_rot"),
    )

    def __init__(
        self,
        grav: float = 9.81,
        expected_angle: float = -360,
        calibration_info_class: type[FerrarisCalibrationInfo] = FerrarisCalibrationInfo,
    ) -> None:
        self.grav = grav
        self.expected_angle = expected_angle
        self.calibration_info_class = calibration_info_class

    def compute(
        self,
        signal_regions: FerrarisSignalRegions,
        sampling_rate_hz: float,
        from_acc_unit: str,
        from_gyr_unit: str,
        **kwargs: Any,
    ) -> FerrarisCalibrationInfo:
        """The calibration: K_a, R_a, b_a, K_g, R_g, K_ga, b_g in units of the samples for 1 m/s^2 and 1 deg/s.

        Given     signal_regions    of ferraris_regions_from_df or ferraris_regions_from_section_list
                  sampling_rate_hz  [Hz]
                  from_acc_unit     units of the samples, which are only written down
                  kwargs            other fields of the answer, for example comment
        Raises    DataError for a section without samples, and where the poses do not show three axes
        Accuracy  1e-9 of imucal, which the tests compare with
        """
        rate = number_of(sampling_rate_hz, "sampling_rate_hz", "accepted are rates above 0 Hz")
        gravity, angle = number_of(self.grav, "grav"), number_of(self.expected_angle, "expected_angle")
        if rate <= 0:
            raise wrong_value("sampling_rate_hz", sampling_rate_hz, "accepted are rates above 0 Hz")
        if gravity == 0 or angle == 0:
            raise UsageError("arguments grav and expected_angle: 0 was given; accepted are other numbers")
        if not isinstance(signal_regions, tuple) or not hasattr(signal_regions, "acc_x_p"):
            raise wrong_type("signal_regions", signal_regions, "accepted is what ferraris_regions_from_df returns")
        k_a, r_a, b_a, k_g, r_g, k_ga, b_g = _tumble.ferraris(
            [_region(getattr(signal_regions, f"acc_{name}"), f"acc_{name}") for name in self.FERRARIS_SECTIONS],
            [_region(getattr(signal_regions, f"gyr_{name}"), f"gyr_{name}") for name in self.FERRARIS_SECTIONS],
            rate,
            gravity,
            angle,
        )
        units: dict[str, Any] = {"acc_unit": self.OUT_ACC_UNIT, "gyr_unit": self.OUT_GYR_UNIT}
        info = self.calibration_info_class(from_acc_unit=from_acc_unit, from_gyr_unit=from_gyr_unit, **units, **kwargs)
        for name, value in {
            "K_a": k_a,
            "R_a": r_a,
            "b_a": b_a,
            "K_g": k_g,
            "R_g": r_g,
            "K_ga": k_ga,
            "b_g": b_g,
        }.items():
            setattr(info, name, _numbers(value))
        return info


class TurntableCalibration(FerrarisCalibration):
    """A FerrarisCalibration with turns of 720 deg by a table."""

    def __init__(
        self,
        grav: float = 9.81,
        expected_angle: float = -720,
        calibration_info_class: type[TurntableCalibrationInfo] = TurntableCalibrationInfo,
    ) -> None:
        super().__init__(grav, expected_angle, calibration_info_class)


def ferraris_regions_from_df(
    df: Any, acc_cols: Iterable[str] = ACC, gyr_cols: Iterable[str] = GYR
) -> FerrarisSignalRegions:
    """The sections of a DataFrame whose index holds their labels x_p, x_a, ... z_rot, in any order and number of parts.

    Given     df        a column for each axis, in any unit
              acc_cols  names of the three columns in the order x, y, z; gyr_cols likewise
    Raises    DataError with the labels that are absent or not known; UsageError with the columns that are absent
    Example   ferraris_regions_from_df(df.set_index("part"))
    """
    if not hasattr(df, "index") or not hasattr(df, "columns"):
        raise wrong_type("df", df, "accepted is a pandas DataFrame with the labels of the sections as index")
    force, rate = _columns(df, acc_cols, "acc_cols"), _columns(df, gyr_cols, "gyr_cols")
    labels = df.index.get_level_values(0) if df.index.nlevels > 1 else df.index
    regions = {}
    for label, rows in _rows_of(labels).items():
        regions["acc_" + label], regions["gyr_" + label] = force[rows], rate[rows]
    return FerrarisSignalRegions(**regions)


def ferraris_regions_from_section_list(
    data: Any, section_list: Any, acc_cols: Iterable[str] = ACC, gyr_cols: Iterable[str] = GYR
) -> FerrarisSignalRegions:
    """The sections of a DataFrame by a list of them: index x_p, x_a, ... z_rot, columns start and end [samples].

    Raises    as ferraris_regions_from_df
    Example   ferraris_regions_from_section_list(df, pd.read_csv("sections.csv", index_col=0))
    """
    force, rate = _columns(data, acc_cols, "acc_cols"), _columns(data, gyr_cols, "gyr_cols")
    if not hasattr(section_list, "columns") or not {"start", "end"} <= set(section_list.columns):
        raise wrong_type("section_list", section_list, "accepted is a DataFrame with the columns start and end")
    _require_sections([str(label) for label in section_list.index])
    regions = {}
    for label, start, end in zip(section_list.index, section_list["start"], section_list["end"], strict=True):
        rows = slice(int(start), int(end))
        regions[f"acc_{label}"], regions[f"gyr_{label}"] = force[rows], rate[rows]
    return FerrarisSignalRegions(**regions)


def _columns(df: Any, names: Iterable[str], argument: str) -> Samples:
    """Three columns, shape (n, 3)."""
    import numpy as np

    if not hasattr(df, "columns"):
        raise wrong_type("df", df, "accepted is a pandas DataFrame")
    wanted = listed(names, argument, "accepted are the names of three columns")
    absent = [name for name in wanted if not isinstance(name, Hashable) or name not in df.columns]
    if absent or len(wanted) != 3:
        raise UsageError(
            f"argument {argument}: {wanted} was given; accepted are three of the columns "
            + ", ".join(map(str, df.columns))
        )
    columns = np.empty((len(df), 3), order="F")  # each column in one piece
    for index, name in enumerate(wanted):
        column = _array_of(df[name], f"df[{name!r}]")
        if column.ndim != 1:
            raise UsageError(f"argument {argument}: {name!r} names several columns; accepted are different names")
        columns[:, index] = column
    return columns


def _rows_of(labels: Any) -> dict[str, Any]:
    """The rows of each label: a slice where they stand together, else their numbers."""
    import numpy as np

    codes, names = labels.factorize()
    _require_sections([str(name) for name in names])
    first = np.concatenate([[0], np.flatnonzero(codes[1:] != codes[:-1]) + 1])
    if len(first) == len(names):
        ends = [*first[1:].tolist(), len(codes)]
        return {str(name): slice(begin, end) for name, begin, end in zip(names, first.tolist(), ends, strict=True)}
    return {str(name): np.flatnonzero(codes == code) for code, name in enumerate(names)}


def _require_sections(labels: list[str]) -> None:
    wanted = FerrarisCalibration.FERRARIS_SECTIONS
    absent = [label for label in wanted if label not in labels]
    unknown = [label for label in labels if label not in wanted]
    problems = [f"argument df: no section {label}; needed are {', '.join(wanted)}" for label in absent]
    problems += [f"argument df: section {label!r} is not known; accepted are {', '.join(wanted)}" for label in unknown]
    if problems:
        raise DataError(problems)


def _region(values: Any, name: str) -> Samples:
    import numpy as np

    array = _array_of(values, name)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise DataError(
            f"section {name}: an array of shape {array.shape} was given; accepted are samples, shape (n, 3)"
        )
    numbers = array.astype(np.float64, copy=False)
    with np.errstate(all="ignore"):
        total = numbers.sum()
    if not np.isfinite(total) and not np.isfinite(numbers).all():  # one pass, where all is well
        absent = np.count_nonzero(~np.isfinite(numbers))
        raise DataError(f"section {name}: {absent} of {numbers.size} values are NaN or infinite; accepted are numbers")
    return numbers


def _numbers(values: Any) -> Samples:
    import numpy as np

    return np.array(values)


def __getattr__(name: str) -> object:
    raise AttributeError(f"tumble.compat.imucal has no {name!r}: it has {', '.join(__all__)}")
