#include "tumble/reduce/compensation/outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/compensate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::compensation {

bool usable_output(const Channel* channel, const Recording& recording, const std::string& role, Problems& problems) {
  if (!channel) {
    problems.push_back(say("the recording has no channel for the role {}", role));
    return false;
  }
  if (find_channel(recording, channel->name + ".compensation_sd")) {
    problems.push_back(say("channel {} is compensated already: it would be subtracted twice", channel->name));
    return false;
  }
  return true;
}

void require_dimension(const Channel* channel, const std::string& unit, Problems& problems) {
  if (channel && channel->unit.dimension() != Unit::parse(unit).dimension())
    problems.push_back(
        say("channel {} is in {}, but must be in {} or the like", channel->name, channel->unit.text(), unit));
}

double number_in(const Table& table, const Table::Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) return *number;
  throw Error(Error::Kind::bad_file,
              say("the result's table {} holds '{}' where a number belongs", table.name, std::get<std::string>(cell)));
}

void refuse(const Recording& recording, Problems problems) {
  if (problems.empty()) return;
  if (!recording.origin.file.empty())
    for (auto& problem : problems) problem = in_file(recording.origin.file, problem);
  throw Error(Error::Kind::bad_data, problems);
}

Trust trust_in(const Channel& output) {
  Trust out{output, output};
  out.sd.name += ".compensation_sd";
  out.extrapolated.name += ".extrapolated";
  out.extrapolated.kind = QuantityKind::other;
  out.extrapolated.unit = Unit();
  return out;
}

}  // namespace tumble::compensation
