#pragma once

#include <functional>
#include <map>
#include <string>

#include "tumble/core/plan.hpp"
#include "tumble/desk/run_desk.hpp"
#include "tumble/station/carry_out.hpp"

namespace tumble {

/// A plan to be carried out on a real rig, or on a virtual one behind real links.
struct PlannedRunAtStation {
  Plan plan;
  Station station;
  std::string folder;                        ///< of the run
  bool resume = false;                       ///< the folder holds a run that was interrupted, which is carried on
  std::map<std::string, std::string> units;  ///< serial number by slot
  std::string who;                           ///< the operator
  std::string date;                          ///< of today, "2026-11-24"
  std::string accept_expired = {};           ///< reason for which equipment out of calibration is accepted
  double speed = 1.0;                        ///< [1] of the station's clock; other than 1 only against a virtual rig
  std::function<double()> clock;             ///< [s] of the wall, which grows
  std::string started = {};                  ///< UTC now, "2026-03-01T12:00:00Z"; empty: nobody says it
  RunCompany company = {};
  RunDesk* desk = nullptr;      ///< where others watch it and give orders; opened in the folder of the run
  std::string rig = {};         ///< "virtual": noted in the store; empty: a real one
  std::uint64_t seed = 1;       ///< of a virtual rig
  bool show_estimates = false;  ///< the estimate so far is for people too, and not for stopping rules alone
};

/// Opens the links of the station, carries the plan out, and leaves the live store complete.
///
/// Throws    Error::bad_input with every reason for which the plan cannot be carried out there, before anything moves;
///           Error::bad_file for links that cannot be opened, and where the run cannot be written
RunEnd run_plan(const PlannedRunAtStation& run);

}  // namespace tumble
