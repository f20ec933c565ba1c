// Reads a log once as users do, with SHA-256 beside, and prints wall seconds, processor seconds and samples of the
// first channel, and the sum of all; bench/imports_ros.py and bench/imports_logs.py compare this with the libraries in
// Python.
//
//   log_reader FILE [TOPIC | -] [VARIABLE...]    VARIABLE: of a MATLAB file, read as plain numbers
#include <chrono>
#include <cstdio>
#include <ctime>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

int main(int count, char** arguments) {
  if (count < 2) return 2;
  tumble::ReadOptions options;
  if (count > 2 && arguments[2] != std::string("-")) options.topics = {arguments[2]};
  for (int i = 3; i < count; ++i) options.units[arguments[i]] = tumble::Unit();
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
