#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/station/virtual_faults.hpp"
#include "tumble/station/virtual_rig.hpp"
#include "tumble/station/wires.hpp"

namespace tumble {

/// Until when faults at random are drawn [s]: twice the schedule and a day, which waiting and attempts do not exceed.
double random_faults_until(const Plan& plan);

/// The other end of all wires of a station: controllers that speak by the same declarations, with the virtual rig of a
/// plan behind them, and instruments that send frames. Pure: it has a simulated clock, which others move.
class VirtualBench {
 public:
  /// Given     plan     whose rig, instruments and truth are simulated
  ///           station  that says which controller drives which axis
  ///           parts    its declarations; must live as long
  ///           seed     of what is drawn
  ///           faults   that happen; empty: none
  ///
  /// Throws    Error::bad_input with all that the plan lacks, and for an axis that the rig does not have
  VirtualBench(const Plan& plan, const Station& station, const StationParts& parts, std::uint64_t seed,
               const std::vector<VirtualFault>& faults = {});
  ~VirtualBench();
  VirtualBench(VirtualBench&&) noexcept;

  double now() const;  ///< [s]
  /// When something happens that nobody sends: an answer, frames, a fault [s].
  double next() const;
  /// Bytes that the station sends over a wire, now.
  void send(std::size_t wire, std::string_view bytes);
  /// Moves the clock on to what happens next, at most to `until` [s]. Returned: what arrives at the station then.
  std::vector<LinkEvent> wait(double until);
  /// A person puts axes somewhere [SI].
  void put(const std::map<std::string, double>& axes);
  /// Switches the instruments, where a run goes on that has switched them before.
  void power(bool on);
  /// Readings of the rig's own sensors of all axes, now.
  std::map<std::string, AxisReading> readings();

  /// The bench as the wires of a station, in simulated time. It must live as long.
  Wires wires();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Where a person who has read the plan puts the axes that are moved by hand before it begins [SI].
std::map<std::string, double> mounted_for(const Plan& plan, const Station& station);

}  // namespace tumble
