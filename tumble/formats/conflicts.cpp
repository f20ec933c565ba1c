#include "tumble/formats/conflicts.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

Problems unit_conflicts(const Recording& recording, const ReadOptions& options) {
  Problems problems;
  for (const auto& [column, unit] : options.units) {
    const auto* channel = find_channel(recording, column);
    if (channel && (channel->unit.factor() != unit.factor() || channel->unit.offset() != unit.offset() ||
                    channel->unit.dimension() != unit.dimension()))
      problems.push_back(
          in_file(recording.origin.file, say("column '{}' is in {} in the file, but {} was given; one is wrong", column,
                                             Name{channel->unit.text()}, Name{unit.text()})));
  }
  return problems;
}

std::optional<Sentence> rate_conflict(const Recording& recording, double said) {
  constexpr double alike = 0.01;
  double other = 0.0;
  for (const auto& channel : recording.channels) {
    const double rate = sampling_rate(channel);
    if (rate > 0.0 && std::abs(rate / said - 1.0) <= alike) return std::nullopt;
    if (other == 0.0) other = rate;
  }
  if (!(other > 0.0)) return std::nullopt;
  return say("--set rate: {} has stamps of its own at {:.6g} Hz, and {:g} Hz was given; one is wrong",
             Name{recording.origin.file}, other, said);
}

void refuse_conflicts(const Recording& recording, const ReadOptions& options) {
  auto problems = unit_conflicts(recording, options);
  if (options.rate)
    if (auto problem = rate_conflict(recording, *options.rate)) problems.push_back(std::move(*problem));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace tumble
