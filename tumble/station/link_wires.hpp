#pragma once

#include <functional>
#include <memory>

#include "tumble/station/station_file.hpp"
#include "tumble/station/wires.hpp"

namespace tumble {

/// The links of a station as its wires: opened when made, and again after they were lost.
class LinkWires {
 public:
  /// Given     clock  [s] of the station, which grows
  ///           speed  [1] how fast it goes against the clock of the wall
  ///
  /// Throws    Error::bad_input for links that are not understood, Error::bad_file for those that cannot be opened: all
  ///           of them at once
  LinkWires(const Station& station, std::function<double()> clock, double speed = 1.0);
  ~LinkWires();

  /// The links as wires of the station. The object must live as long.
  Wires wires();

  /// The file of a wire, for one who sends when this process does not; -1: it is not up.
  int descriptor(std::size_t wire) const;
  /// Sets a function that gets the file of a wire that was opened again, or -1 for one that was lost.
  void tell_changes(std::function<void(std::size_t wire, int descriptor)> tell);

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
