// Identifies the error model of a fibre-optic gyro from one session and subtracts it from another.
//
//   04_compensate PLAN

#include <cmath>
#include <cstdio>
#include <exception>

#include "tumble/tumble.hpp"

namespace {

/// Standard deviation of a channel about its mean [SI]; a missing sample is NaN and is skipped.
double scatter(const tumble::Recording& recording, const char* name) {
  const auto* channel = tumble::find_channel(recording, name);
  if (channel == nullptr) return std::nan("");
  double count = 0.0, mean = 0.0, squares = 0.0;
  for (const double value : channel->values) {
    if (std::isnan(value)) continue;
    count += 1.0;
    const double step = value - mean;
    mean += step / count;
    squares += step * (value - mean);
  }
  return std::sqrt(squares / (count - 1.0));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: 04_compensate PLAN\n");
    return 2;
  }
  try {
    const auto plan = tumble::load_plan(argv[1], {});
    const auto estimate = tumble::identify({plan, {tumble::simulate(plan, 1, {})}}, {});

    const auto session = tumble::simulate(plan, 2, {});
    const auto compensated = tumble::compensate(estimate, session);
    const auto unit = tumble::Unit::parse("deg/h");
    std::printf("scatter of the gyro before %.4f deg/h\n", unit.from_si(scatter(session, "gyro")));
    std::printf("scatter of the gyro after  %.4f deg/h\n", unit.from_si(scatter(compensated.recording, "gyro")));
    for (const auto& channel : compensated.recording.channels) std::printf("channel %s\n", channel.name.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
