#pragma once

#include <gtest/gtest.h>

#include "tumble/rigs/rig.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

/// For the tests of rigs: a place, and what is felt there.
namespace tumble {

inline const Site site{34.0 * degree, 108.0 * degree, 400.0, 9.7966};

inline Settings with(const Rig& rig, const std::vector<Given>& given) {
  Problems problems;
  auto options = resolve(rig.options(), given, rig.name, problems);
  EXPECT_TRUE(problems.empty()) << problems.front().text();
  return options;
}

inline RigRun run_of(const Schedule& schedule, const Settings& options, double rate = 100.0) {
  return {schedule, options, site, rate, {}, RandomStream(7)};
}

inline std::vector<Felt> felt(const Reference& reference, double first, double step, std::size_t count) {
  std::vector<Felt> out(count);
  reference.felt(first, step, out);
  return out;
}

}  // namespace tumble
