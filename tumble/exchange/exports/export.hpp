#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/option.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/exchange/calibration.hpp"

namespace tumble {

/// A catalogue entry of exchange/exports/: writes a calibration for one consumer.
struct Export {
  const char* name;
  const char* summary;
  const char* formula;  ///< of the consumer, in words, as the header of each file has it
  const char* units;    ///< of the file
  const char* frame;    ///< axes in which the consumer works
  const char* source;   ///< where the formula stands: repository and file, or page
  const char* comment;  ///< what begins a line of comment in the file; empty: comments are not possible
  const char* extension;
  std::vector<std::string> (*carries)();    ///< names of calibration terms that the file carries
  std::vector<std::string> (*estimates)();  ///< terms that the consumer estimates itself; the header states them
  bool takes_counts;                        ///< outputs may be counts, volts and the like
  std::vector<Option> (*options)();
  /// The file, with these lines of its header as comments. Throws Error::bad_input with all that is missing.
  std::string (*write)(const ImuCalibration& calibration, const Settings& settings,
                       const std::vector<std::string>& header);
};

/// All entries, in the order of their names.
const std::vector<const Export*>& export_catalogue();
/// The entry of that name ("lio-sam" is lio_sam), or Error::unsupported with the nearest known name.
const Export& find_export(std::string_view name);

/// Wishes of a user for an export.
struct ExportRequest {
  std::vector<Given> settings = {};    ///< `--set key=value`
  std::vector<std::string> drop = {};  ///< names of terms that may be lost
  double inflate = 1.0;                ///< [1] N and K are multiplied by it
};

/// Options of every export: `axes`, `rate_range`, `force_range`, `date`, and noise in place of that of the results.
std::vector<Option> common_export_options();

/// The file for a consumer.
///
/// Throws    Error::bad_input where the consumer cannot carry a term of the calibration that `drop` does not name, with
///           the error that each of them leaves; where a setting is wrong or missing
std::string export_calibration(const Export& entry, ImuCalibration calibration, const ExportRequest& request);

}  // namespace tumble
