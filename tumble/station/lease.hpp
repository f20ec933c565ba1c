#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tumble/station/station_file.hpp"

namespace tumble {

/// A station that a process of this machine uses, or has left without an end.
struct LeaseHolder {
  long process = 0;  ///< 0: not known
  std::string run;   ///< folder, absolute
};

/// The right to use the devices of a station: one run at a time for each device, under any name of its link: by the
/// addresses of a host, by the numbers of a serial device. It is the same for all users of the machine and for any
/// TMPDIR. It ends with the process, also where that is killed; what a killed process has left is then known from the
/// lease.
class Lease {
 public:
  /// Throws    Error::bad_file that says which run has a device of the station
  Lease(const Station& station, const std::string& run);
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  ~Lease();

  /// Runs that had a device of this station and did not end by themselves: the rig may be moving.
  const std::vector<LeaseHolder>& left_behind() const { return left_; }
  /// The run has ended, and the rig is safe. Without this, or where it cannot be written, the next run finds it in
  /// left_behind().
  void end();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
  std::vector<LeaseHolder> left_;
};

/// The runs that are going on on this machine.
std::vector<LeaseHolder> runs_going_on();

}  // namespace tumble
