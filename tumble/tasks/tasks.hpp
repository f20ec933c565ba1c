#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/methods/method.hpp"

namespace tumble::tasks {

/// One `--set key=value`.
using Sets = std::vector<std::pair<std::string, std::string>>;

/// Reads and checks a plan: every unknown key, bare number, wrong dimension and unknown name at once, with its line.
/// `sets` override [settings] (plain key), [truth] ("truth.key") and [rig] ("rig.key").
/// Throws Error::bad_input (exit 2).
Plan load_plan(const std::string& path, const Sets& sets);

/// A plan that is only a method's name and its settings, for methods that need none.
Plan plan_for_method(const std::string& method, const Sets& sets);

/// Reads the recordings (the plan's, then those given), assigns marks from the schedule, checks roles and units.
Evidence gather(Plan plan, const std::vector<std::string>& recordings, const Sets& sets, const Progress& progress);

/// Runs the plan's method; adds the findings of the checks, judges the limits, fills in the provenance.
Estimate identify(const Evidence& evidence, const Progress& progress);

Recording simulate(const Plan& plan, unsigned long long seed, const Progress& progress);

Estimate predict(const Plan& plan);

Compensation compensate(const Estimate& estimate, const Recording& recording);

/// Pass, fail or undecided for every limit, from the 95 % interval. Unknown parameters and wrong units are problems.
std::vector<Verdict> judge(const std::vector<Limit>& limits, const Estimate& estimate);

}  // namespace tumble::tasks
