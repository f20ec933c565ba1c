#pragma once

#include <string>
#include <vector>

#include "tumble/exchange/calibration.hpp"
#include "tumble/exchange/exports/export.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {

/// One result of an export: a file, or what a caller has in memory.
struct ExportSource {
  std::string file;       ///< for messages and for the header
  std::string text;       ///< the result's JSON
  std::string axis = {};  ///< "gyro_y", of a result of a single sensor
};

/// "gyro_y=tumble.json" or "tumble.json", read whole. Throws Error::bad_file.
ExportSource export_source(const std::string& argument);

/// Wishes of a user for an export, apart from the results.
struct ExportWish {
  std::string to;  ///< name of the consumer
  Sets sets = {};
  std::vector<std::string> drop = {};
  double inflate = 1.0;  ///< [1]
};

/// The calibration of these results as the file of a consumer; the hash of each is that of its text.
/// Throws Error::unsupported for a consumer that is not known; Error::bad_file for a text that is no result;
/// Error::bad_input with every term that the consumer cannot carry and every setting that is missing.
std::string export_results(const std::vector<ExportSource>& sources, const ExportWish& wish);

}  // namespace tumble
