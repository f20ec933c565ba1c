// Reads a log once as users do, with SHA-256 beside, and prints wall seconds, processor seconds and samples of the
// first channel; bench/imports_ros.py compares this with the libraries in Python.
//
//   log_reader FILE [TOPIC]
#include <chrono>
#include <cstdio>
#include <ctime>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

int main(int count, char** arguments) {
  if (count < 2) return 2;
  tumble::ReadOptions options;
  if (count > 2) options.topics = {arguments[2]};
  try {
    const auto wall = std::chrono::steady_clock::now();
    const auto cpu = std::clock();
    const auto recording = tumble::read_recording(arguments[1], options, {});
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
    double sum = 0.0;
    for (const auto& channel : recording.channels)
      for (const double value : channel.values) sum += value;
    std::printf("%.6f %.6f %zu %.17g\n", seconds.count(), static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC,
                recording.channels.front().values.size(), sum);
    return 0;
  } catch (const tumble::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
