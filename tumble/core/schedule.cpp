#include "tumble/core/schedule.hpp"

#include <cmath>

#include "tumble/math/shaped_noise.hpp"

namespace tumble {

Sentence place_of_segment(const std::string& label) { return say("segment '{}'", label); }

double rms_of(const Motion& random) { return std::sqrt(variance({random.psd_frequency, random.psd})); }

std::vector<AxisCommand> commands_to(const Schedule& run, const std::string& axis) {
  std::vector<AxisCommand> commands;
  double begin = 0.0;
  for (std::size_t s = 0; s < run.size(); ++s) {
    const auto found = run[s].axes.find(axis);
    const Motion* motion = found == run[s].axes.end() ? nullptr : &found->second;
    if (motion && motion->continued && !commands.empty())
      commands.back().duration += run[s].duration;
    else
      commands.push_back({s, begin, run[s].duration, motion});
    begin += run[s].duration;
  }
  return commands;
}

}  // namespace tumble
