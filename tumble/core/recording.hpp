#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/finding.hpp"

namespace tumble {

/// The beginning of a segment in a recording. A segment ends where the next begins, the last with the data.
struct Mark {
  std::string label;
  double begin = 0.0;  ///< [s] on the recording's own clock
  int run = 1;         ///< which power-up
  /// [s] on the recording's own clock, as the schedule says; infinity: as long as samples follow
  double end = std::numeric_limits<double>::infinity();
};

struct Origin {
  std::string file;  ///< as the user wrote it; empty for simulated data
  /// SHA-256 of its bytes, which another thread works out while the samples are used; null for simulated data.
  std::function<std::string()> checksum = {};
};

/// Lower-case hex, waited for; empty for simulated data. Throws Error::bad_file where the file cannot be read to its
/// end.
std::string sha256_of(const Origin& origin);

/// A property that a reader recognised in a file that does not say it plainly: {"encoding", "GB18030"}.
struct Recognised {
  std::string what;
  std::string how;
};

/// Measurements of one file.
struct Recording {
  std::string instrument;  ///< model and serial, as the file says
  std::vector<Channel> channels;
  std::vector<Mark> marks;  ///< in order of time; empty: one run, one segment
  Origin origin;
  std::map<std::string, std::string> meta;  ///< anything else the file carries
  Findings findings;                        ///< what the reader noticed
  std::vector<Recognised> recognised = {};  ///< how it understood the file; empty where nothing was to be recognised
};

/// The channel of that name, or null.
const Channel* find_channel(const Recording& recording, std::string_view name);

}  // namespace tumble
