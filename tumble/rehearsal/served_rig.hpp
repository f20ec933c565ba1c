#pragma once

#include <atomic>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tumble/rehearsal/serve_bench.hpp"
#include "tumble/rehearsal/virtual_bench.hpp"

namespace tumble {

/// The virtual rig of a plan at the links of a station, served by a thread of its own until it is destroyed.
class ServedRig {
 public:
  static constexpr std::uint64_t seed = 1;  ///< of what it draws
  /// Given     speed  [1] of its clock
  ///
  /// Throws    Error::bad_file with all ports that cannot be had
  ServedRig(const Plan& plan, const Station& station, double speed, const std::vector<VirtualFault>& faults = {});
  ServedRig(const ServedRig&) = delete;
  ServedRig& operator=(const ServedRig&) = delete;
  ~ServedRig();
  /// Where each wire is reached: devices, then instruments.
  const std::vector<std::string>& addresses() const { return server_->addresses(); }
  /// Ends the service. Returns how the rig is: axes by name.
  std::map<std::string, AxisReading> end();

 private:
  Station station_;
  StationParts parts_;
  VirtualBench bench_;
  std::optional<BenchServer> server_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace tumble
