// Reads a log once and prints wall seconds, processor seconds and samples of the first channel, and the sum of all;
// bench/imports_ros.py and bench/imports_logs.py compare this with the libraries in Python.
//
//   log_reader [--stream] FILE [TOPIC | -] [VARIABLE...]    VARIABLE: of a MATLAB file, read as plain numbers
//
// As users read it: into memory, with SHA-256 beside. --stream: block after block, of which only the sum is kept,
// without SHA-256, as a loop over the messages does.
#include <chrono>
#include <cstdio>
#include <ctime>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

namespace {

/// What was read.
struct Total {
  std::size_t samples = 0;  ///< of the first channel
  double sum = 0.0;         ///< of all channels

  void add(const tumble::Recording& recording) {
    samples += recording.channels.front().values.size();
    for (const auto& channel : recording.channels)
      for (const double value : channel.values) sum += value;
  }
};

}  // namespace

int main(int count, char** arguments) {
  const bool stream = count > 1 && arguments[1] == std::string("--stream");
  if (stream) ++arguments, --count;
  if (count < 2) return 2;
  tumble::ReadOptions options;
  if (count > 2 && arguments[2] != std::string("-")) options.topics = {arguments[2]};
  for (int i = 3; i < count; ++i) options.units[arguments[i]] = tumble::Unit();
  try {
    const auto wall = std::chrono::steady_clock::now();
    const auto cpu = std::clock();
    Total total;
    tumble::Recording whole;
    if (stream)
      tumble::stream_recording(tumble::format_of(arguments[1], options), arguments[1], options, 1 << 16,
                               [&](const tumble::Recording& block) { total.add(block); }, {});
    else
      whole = tumble::read_recording(arguments[1], options, {});
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
    if (!stream) total.add(whole);
    std::printf("%.6f %.6f %zu %.17g\n", seconds.count(), static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC,
                total.samples, total.sum);
    return 0;
  } catch (const tumble::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
