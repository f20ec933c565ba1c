#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/error.hpp"

namespace tumble {

const Trials& trials_of(const Method& method) {
  const auto& all = trials_catalogue();
  const auto match = std::ranges::find_if(all, [&](const auto& entry) { return entry.first == method.name; });
  if (match == all.end())
    throw Error(Error::Kind::internal, say("there is no methods/{}/testing/trials.cpp", Name{method.name}));
  return *match->second;
}

Trial trial_of(const Method& method, std::uint64_t seed) { return trials_of(method).first(seed); }

Trial second_trial_of(const Method& method, std::uint64_t seed) { return trials_of(method).second(seed); }

}  // namespace tumble
