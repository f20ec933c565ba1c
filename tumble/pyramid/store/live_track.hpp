#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "tumble/pyramid/store/mapped.hpp"
#include "tumble/pyramid/store/paged.hpp"

namespace tumble::store {

/// A file that is open.
struct OpenFile {
  int descriptor = -1;
  explicit OpenFile(int opened) : descriptor(opened) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile();
};

/// Samples that lie together in a file of LiveSamples.
struct LiveRun {
  std::uint64_t first = 0;              ///< number of the first one
  std::uint64_t times = 0, values = 0;  ///< places in the file
};

/// Where the samples of a channel and their times were found at a moment.
struct LiveTrack {
  std::shared_ptr<const OpenFile> file;
  std::size_t count = 0;  ///< samples
  std::size_t run_count = 0;
  Paged<LiveRun> runs;
  Paged<double> bar_times;  ///< [s] of the first sample of each bar

  double time(std::size_t sample) const;    ///< [s]
  std::size_t index_at(double time) const;  ///< as Pyramid::index_at(), time [s]
  /// Appends samples [SI], and times [s], first .. first + number - 1. Throw Error::bad_file.
  void read(std::size_t first, std::size_t number, std::vector<double>& to) const;
  void read_times(std::size_t first, std::size_t number, std::vector<double>& to) const;

 private:
  void read(std::uint64_t LiveRun::*place, std::size_t first, std::size_t number, std::vector<double>& to) const;
};

}  // namespace tumble::store
