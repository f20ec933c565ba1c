#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/formats/ros/stream.hpp"

namespace tumble::ros {

/// Samples of a stream, one after the other in the order of the file.
struct Samples {
  std::vector<std::int64_t> stamps;         ///< [ns] header.stamp
  std::vector<std::int64_t> received;       ///< [ns] when it was recorded
  std::vector<std::vector<double>> values;  ///< of each column, in its unit
  std::size_t count = 0;                    ///< the vectors may be longer
  std::size_t unreadable = 0;               ///< messages whose bytes are not what their type says
  std::vector<char> measured;               ///< of each column: some message says that it is measured
  std::string frame;                        ///< header.frame_id of the first
  std::string other_frame;                  ///< of the first that has another one

  std::vector<char> room;  ///< for a message that is packed by itself

  explicit Samples(const Stream& stream);
  Samples(Samples&&) noexcept = default;
  void add(const Stream& stream, const Message& message);
  void clear();

 private:
  /// Where the numbers of a column go, and which they are of a message.
  struct Lane {
    double* values;
    std::size_t number;
  };

  void take_frame(std::string_view name);
  void make_longer(const Stream& stream);

  std::string frame_id_;  ///< the bytes of `frame`
  std::vector<Lane> lanes_;
  bool all_measured_ = false;
};

/// Where a file could not be read, and how much it holds.
struct ScanReport {
  std::map<std::uint32_t, Count> counts;
  std::size_t damaged = 0;        ///< pieces
  std::uint64_t first_place = 0;  ///< [bytes]
  std::string first_reason;
};

/// Samples of all streams in one stretch of the file.
using Stretch = std::vector<Samples>;

/// Reads all pieces on all threads, and hands out what they hold in the order of the file, a few stretches at a time.
/// Given: take, called from one thread in that order; progress, done [1].
ScanReport scan(const Log& log, const std::vector<Stream>& streams,
                const std::function<void(std::span<const Stretch* const>)>& take, const Progress& progress);

}  // namespace tumble::ros
