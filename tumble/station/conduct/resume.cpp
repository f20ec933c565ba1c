// What a run that goes on takes from what it has recorded.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tumble/recorder/recorder_read.hpp"
#include "tumble/station/carry_out.hpp"

namespace tumble {

std::vector<RunRow> journal_of(const std::string& run) {
  std::vector<RunRow> rows;
  visit_store(run, [&](const StoreItem& item) {
    if (item.journal) rows.push_back(*item.journal);
  });
  return rows;
}

double end_of(const std::string& run) {
  double end = 0.0;
  visit_store(run, [&](const StoreItem& item) { end = std::max(end, item.time); });
  return end;
}

Wires shifted(Wires wires, double later) {
  wires.now = [now = wires.now, later] { return now() + later; };
  wires.wait = [wait = wires.wait, later](double until) {
    double there = until - later;
    while (there + later < until)
      there = std::nextafter(there, std::numeric_limits<double>::infinity());  // else that time would never come
    auto events = wait(there);
    for (LinkEvent& event : events) event.time += later;
    return events;
  };
  return wires;
}

}  // namespace tumble
