#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "tumble/rehearsal/virtual_bench.hpp"
#include "tumble/station/station_file.hpp"

namespace tumble {

/// A virtual bench at the links of a station, for programs that know nothing of it: TCP ports of this machine, and
/// pseudo-terminals in place of serial lines.
class BenchServer {
 public:
  /// Given     clock  [s] that the bench follows
  ///           speed  [1] how fast that clock goes against the clock of the wall
  ///
  /// Throws    Error::bad_file with all ports that cannot be had
  BenchServer(VirtualBench& bench, const Station& station, std::function<double()> clock, double speed = 1.0);
  ~BenchServer();

  /// Where each wire is reached: "tcp:127.0.0.1:9000", "serial:/dev/pts/3".
  const std::vector<std::string>& addresses() const;
  /// Serves until `stop` is true, looking at it every 50 ms.
  void serve(const std::atomic<bool>& stop);

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
