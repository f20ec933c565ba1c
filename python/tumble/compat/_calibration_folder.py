"""Calibrations in a folder: the functions of imucal.management. The name of a file says the sensor and the date."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from tumble._errors import DataError, FileError, TumbleWarning, wrong_type, wrong_value
from tumble._text import one_of, path_text, whole_text
from tumble.compat._calibration_info import CalibrationInfo

STAMP = "%Y-%m-%d_%H-%M"


class CalibrationWarning(TumbleWarning):
    """The closest calibration is older, or newer, than it should be."""


def save_calibration_info(
    cal_info: CalibrationInfo,
    sensor_id: str,
    cal_time: datetime,
    folder: str | os.PathLike[str],
    folder_structure: str = "{sensor_id}/{cal_info.CAL_TYPE}",
    **kwargs: Any,
) -> Path:
    """Writes a calibration to folder/folder_structure/SENSOR_DATE.json, and returns this path.

    Given     sensor_id         letters and digits; the name of the file has small letters
              cal_time          when the calibration was made, to the minute
              folder_structure  subfolders, with {sensor_id}, {cal_info.ATTRIBUTE} and the names of kwargs
    """
    if not whole_text(sensor_id, "sensor_id").isalnum():
        raise wrong_value("sensor_id", sensor_id, "accepted are letters and digits")
    if not hasattr(cal_time, "strftime"):
        raise wrong_type("cal_time", cal_time, "accepted is a datetime")
    sensor = sensor_id.lower()
    place = Path(path_text(folder, "folder")) / folder_structure.format(
        sensor_id=sensor_id, cal_info=cal_info, **kwargs
    )
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{place}: {error}") from error
    path = place / f"{sensor}_{cal_time.strftime(STAMP)}.json"
    cal_info.to_json_file(path)
    return path


def load_calibration_info(
    path: str | os.PathLike[str], file_type: str | None = None, base_class: type[CalibrationInfo] = CalibrationInfo
) -> CalibrationInfo:
    """The calibration of a file of to_json_file or to_hdf5; file_type "json" or "hdf", None: by the end of the name."""
    suffix = Path(path_text(path, "path")).suffix[1:].lower()
    kind = {"json": "json", "hdf": "hdf", "h5": "hdf", "hdf5": "hdf"}.get(suffix) if file_type is None else file_type
    if kind not in ("json", "hdf"):
        raise wrong_value("file_type", file_type, f"accepted for {os.fspath(path)!r} are json and hdf")
    return base_class.from_json_file(path) if kind == "json" else base_class.from_hdf5(path)


def find_calibration_info_for_sensor(
    sensor_id: str,
    folder: str | os.PathLike[str],
    recursive: bool = True,
    filter_cal_type: str | None = None,
    custom_validator: Callable[[CalibrationInfo], bool] | None = None,
    ignore_file_not_found: bool | None = False,
) -> list[Path]:
    """The files of a folder that hold a calibration of the sensor, by their names, the oldest first.

    Given     filter_cal_type   only this type, for example "Ferraris": the files are read
              custom_validator  only calibrations for which it is true
    Raises    DataError where there are none, unless ignore_file_not_found
    """
    pattern, place = f"{whole_text(sensor_id, 'sensor_id').lower()}_*.json", Path(path_text(folder, "folder"))
    try:
        found = sorted(place.rglob(pattern) if recursive else place.glob(pattern), key=lambda one: one.name)
    except OSError as error:
        raise FileError(f"{place}: {error}") from error
    except (ValueError, NotImplementedError) as error:  # of a pattern such as "**a"
        raise wrong_value("sensor_id", sensor_id, "accepted are letters and digits") from error
    found = [one for one in found if _date_of(one) is not None]
    if filter_cal_type is not None or custom_validator is not None:
        read = [(one, load_calibration_info(one)) for one in found]
        wanted = None if filter_cal_type is None else filter_cal_type.lower()
        found = [
            one
            for one, info in read
            if (wanted is None or (info.CAL_TYPE or "").lower() == wanted)
            and (custom_validator is None or custom_validator(info))
        ]
    if not found and not ignore_file_not_found:
        raise DataError(f"{os.fspath(folder)}: no calibration of the sensor {sensor_id!r}")
    return found


def find_closest_calibration_info_to_date(
    sensor_id: str,
    cal_time: datetime,
    folder: str | os.PathLike[str] = ".",
    recursive: bool = True,
    filter_cal_type: str | None = None,
    custom_validator: Callable[[CalibrationInfo], bool] | None = None,
    before_after: str | None = None,
    warn_thres: timedelta = timedelta(days=30),
    ignore_file_not_found: bool | None = False,
) -> Path | None:
    """The file of the calibration that was made closest to a date; of two that are equally close, the one before.

    Given     before_after  "before" or "after": only those on this side of the date
              warn_thres    a CalibrationWarning says that the closest is further away
    Returned  None where there is none and ignore_file_not_found is true
    Raises    DataError where there is none
    """
    if before_after is not None:
        one_of(before_after, "before_after", ("before", "after"))
    if not isinstance(cal_time, datetime):
        raise wrong_type("cal_time", cal_time, "accepted is a datetime")
    paths = find_calibration_info_for_sensor(
        sensor_id, folder, recursive, filter_cal_type, custom_validator, ignore_file_not_found
    )
    dated = [(date, path) for path in paths if (date := _date_of(path)) is not None]
    if before_after is not None:
        dated = [one for one in dated if (one[0] <= cal_time if before_after == "before" else one[0] >= cal_time)]
    if not dated:
        if ignore_file_not_found:
            return None
        raise DataError(f"{os.fspath(folder)}: no calibration of {sensor_id!r} {before_after} {cal_time}")
    date, path = min(dated, key=lambda one: (abs(one[0] - cal_time), one[0]))
    if abs(date - cal_time) > warn_thres:
        text = f"the closest calibration of {sensor_id!r} is {abs(date - cal_time)} away from {cal_time}: {path.name}"
        warnings.warn(text, CalibrationWarning, stacklevel=2)
    return path


def _date_of(path: Path) -> datetime | None:
    """The date in the name of a file; None where there is none."""
    try:
        return datetime.strptime(path.stem.partition("_")[2], STAMP)
    except ValueError:
        return None
