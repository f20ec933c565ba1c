#pragma once

#include <string>
#include <vector>

#include "tumble/archive/history.hpp"
#include "tumble/core/progress.hpp"

namespace tumble {

/// A result made again from what the archive has of it, compared with the archived one.
struct Recomputation {
  bool same = false;        ///< equal to the last byte, except for the folders of its files
  bool same_bytes = false;  ///< these too
  std::string archived_sha256, new_sha256;
  std::string archived_program, new_program;  ///< versions
  std::vector<std::string> differing;         ///< members of the result JSON that differ: "parameters", "budget"
  std::string parameter;                      ///< the one whose value differs most; empty: none does
  double difference = 0.0;                    ///< [1] of this value, in standard uncertainties of the archived one
};

/// Repeats a result from its archived recordings, plan, settings and values of the command line.
///
/// Given     sha256   of the result
///           scratch  an empty folder, for the files
/// Throws    Error::bad_input with every file that the archive does not have; Error::bad_file where one has changed; as
///           identify()
Recomputation recompute(const Archive& archive, const std::string& sha256, const std::string& scratch,
                        const Progress& progress = {});

}  // namespace tumble
