// Reads a recording, says what is in it and what is odd about it, and works with the samples of one channel.
//
//   01_read_and_inspect RECORDING

#include <cmath>
#include <cstdio>
#include <exception>

#include "tumble/tumble.hpp"

namespace {

/// Everything inside the library is in SI; a unit turns it into what people read.
void print(const tumble::ChannelSummary& channel) {
  const tumble::Unit& unit = channel.unit;
  std::printf("%-12s %6zu samples  %7.2f Hz  mean %9.4f  sd %8.4f %s\n", channel.name.c_str(), channel.samples,
              channel.rate(), unit.from_si(channel.mean), unit.difference_from_si(channel.sd), unit.text().c_str());
}

/// Mean of the samples before `end` [s]; a missing sample is NaN and is skipped.
double mean_until(const tumble::Channel& channel, double end) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < channel.values.size() && channel.time(i) < end; ++i) {
    if (std::isnan(channel.values[i])) continue;
    sum += channel.values[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : std::nan("");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: 01_read_and_inspect RECORDING\n");
    return 2;
  }
  try {
    const auto inspection = tumble::inspect(argv[1], {}, {});
    for (const auto& channel : inspection.channels) print(channel);
    std::printf("findings: %zu\n", inspection.findings.size());
    for (const auto& finding : inspection.findings)
      std::printf("  %s%s%s\n", finding.where.c_str(), finding.where.empty() ? "" : ": ", finding.message.c_str());

    const auto recording = tumble::read_recording(argv[1], {}, {});
    if (const auto* gyro = tumble::find_channel(recording, "gyro.x"))
      std::printf("gyro.x in the first minute: %.4f %s\n", gyro->unit.from_si(mean_until(*gyro, 60.0)),
                  gyro->unit.text().c_str());
  } catch (const std::exception& error) {  // tumble::Error says what, where and what would be accepted
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
