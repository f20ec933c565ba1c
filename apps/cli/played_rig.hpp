#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

#include "tumble/station/serve_bench.hpp"

namespace tumble::cli {

/// The rig of a plan, played at the links of a station by a thread of this process until it is destroyed.
class PlayedRig {
 public:
  /// Given     speed  [1] of its clock
  ///
  /// Throws    Error::bad_file with all ports that cannot be had
  PlayedRig(const Plan& plan, const Station& station, double speed, std::uint64_t seed = 1);
  PlayedRig(const PlayedRig&) = delete;
  PlayedRig& operator=(const PlayedRig&) = delete;
  ~PlayedRig();

 private:
  Station station_;
  StationParts parts_;
  VirtualBench bench_;
  std::optional<BenchServer> server_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace tumble::cli
