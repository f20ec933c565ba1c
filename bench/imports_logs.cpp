// Reads a log or a MATLAB file once and prints how long it took; bench/imports_logs.py compares this with the peers.
//
//   imports_logs FILE [VARIABLE...]    VARIABLE: of MATLAB, taken as plain numbers
//
// Prints wall and processor time [s], the number of samples and their sum.
#include <chrono>
#include <cstdio>
#include <ctime>
#include <numeric>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

int main(int count, char** arguments) {
  if (count < 2) return 2;
  tumble::ReadOptions options;
  for (int i = 2; i < count; ++i) options.units[arguments[i]] = tumble::Unit();
  try {
    const auto wall = std::chrono::steady_clock::now();
    const auto cpu = std::clock();
    const auto recording = tumble::read_recording(arguments[1], options, {});
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
    const double busy = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    double sum = 0.0;
    std::size_t samples = 0;
    for (const auto& channel : recording.channels) {
      samples += channel.values.size();
      sum = std::accumulate(channel.values.begin(), channel.values.end(), sum);
    }
    std::printf("%.6f %.6f %zu %.17g\n", seconds.count(), busy, samples, sum);
    return 0;
  } catch (const tumble::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
