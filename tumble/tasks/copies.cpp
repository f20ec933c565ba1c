#include "tumble/tasks/copies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Numbers in the place of values: 0, 1, ... in the order in which they first come; missing samples are one value.
std::vector<std::size_t> names_of_values(const std::vector<double>& values) {
  std::map<double, std::size_t> seen;
  std::vector<std::size_t> names;
  constexpr double missing = INFINITY;
  for (const double v : values)
    names.push_back(seen.try_emplace(std::isnan(v) ? missing : v, seen.size()).first->second);
  return names;
}

/// How often each value follows one state.
struct Followers {
  std::map<std::size_t, double> counts;
  double all = 0.0;

  void add(std::size_t value) { ++counts[value], ++all; }
  /// Chance that two draws are equal, of n(n - 1)/2 pairs at least one.
  double equal() const {
    double pairs = 0.0;
    for (const auto& [value, n] : counts) pairs += n * (n - 1.0);
    return std::max(pairs, 1.0) / std::max(1.0, all * (all - 1.0));
  }
};

double log_chance_of(const std::vector<double>& values) {
  constexpr double enough = 8.0;
  const auto names = names_of_values(values);
  std::map<std::array<std::size_t, 2>, Followers> after_two;
  std::map<std::size_t, Followers> after_one;
  Followers after_any;
  for (std::size_t i = 0; i < names.size(); ++i) {
    after_any.add(names[i]);
    if (i > 0) after_one[names[i - 1]].add(names[i]);
    if (i > 1) after_two[{names[i - 2], names[i - 1]}].add(names[i]);
  }
  const double any = after_any.equal();
  double sum = 0.0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    double chance = any;
    if (i > 0 && after_one[names[i - 1]].all >= enough) chance = after_one[names[i - 1]].equal();
    if (i > 1)
      if (const auto& two = after_two[{names[i - 2], names[i - 1]}]; two.all >= enough) chance = two.equal();
    sum += std::log(chance);
  }
  return sum;
}

std::vector<double> intervals_of(const std::vector<double>& stamps) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  return intervals;
}

}  // namespace

double log_chance_of_equal(const Recording& recording) {
  double sum = 0.0;
  const std::vector<double>* stamps = nullptr;
  for (const auto& channel : recording.channels) {
    sum += log_chance_of(channel.values);
    if (channel.timeline.uniform() || channel.timeline.stamps.get() == stamps) continue;
    stamps = channel.timeline.stamps.get();
    sum += log_chance_of(intervals_of(*stamps));
  }
  return sum;
}

void look_at_copies(std::vector<Recording>& recordings) {
  const double least = std::log(1e-6);
  Problems problems;
  for (std::size_t a = 0; a < recordings.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const auto sum = sha256_of(recordings[a].origin);
      if (sum.empty() || sum != sha256_of(recordings[b].origin)) continue;
      const auto &file = recordings[a].origin.file, &other = recordings[b].origin.file;
      if (file != other && log_chance_of_equal(recordings[a]) > least)
        recordings[a].findings.push_back({Finding::Severity::info, "equal_to_another_recording", {{"other", other}}});
      else
        problems.push_back(
            say("{} holds the same bytes as {}: a recording can be used only once", Name{file}, Name{other}));
    }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace tumble
