#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tumble/station/carry_out.hpp"
#include "tumble/station/station_file.hpp"

/// A second process beside that of a run: it has the links of the devices open too, and knows the bytes of the safe
/// list. When the process of the run ends in any way without a word, or does not look at the rig any more, it sends
/// them.
namespace tumble {

/// One command of the safe list as bytes, for one who waits for no reply.
struct GuardOrder {
  std::size_t wire = 0;
  std::string device;
  ControllerVerb verb{};
  std::vector<std::string> bytes;  ///< of each exchange
  double after = 0.0;              ///< [s of the wall] that those before it have
  bool again = true;               ///< it may be sent a second time
};

/// Given     speed  [1] of the station's clock against that of the wall
std::vector<GuardOrder> guard_orders_of(const Station& station, const StationParts& parts, double speed);

class RigGuard {
 public:
  /// Starts the process. It is of no use before arm().
  ///
  /// Given     folder       of the run, where it keeps what it has done
  ///           descriptors  by wire; -1: not open
  ///           patience     [s] without a look at the rig, after which it acts
  ///
  /// Throws    Error::bad_file where the process cannot be started
  RigGuard(const std::string& folder, const std::vector<GuardOrder>& orders, const std::vector<int>& descriptors,
           double patience);
  RigGuard(const RigGuard&) = delete;
  RigGuard& operator=(const RigGuard&) = delete;
  ~RigGuard();  ///< one that is armed and was not dismissed acts

  void arm();     ///< from now on the rig may move
  void disarm();  ///< it is at rest, and nobody looks at it for a while
  /// The rig was looked at. A guard that is not there any more is replaced. Returned: why the guard has stopped the
  /// rig, or must; empty: all is well.
  Sentence looked();
  void link_changed(std::size_t wire, int descriptor);
  void dismiss();  ///< the rig is safe, or people know that it is not

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// The process of the run is about to end by a fault: its guard acts now, and does not wait until the process has
/// written its memory to a file, or its last words to a terminal. May be called by a signal handler.
void leave_rig_to_guard();

/// Ends the guard that a run has left, once it has sent the first of its commands. Returns at once without such a
/// guard.
/// Throws Error::bad_file for one that does not end.
void relieve_guard(const std::string& run);

/// Actions of the guard of a run, as a sentence; empty: none.
Sentence words_of_guard(const std::string& run);

}  // namespace tumble
