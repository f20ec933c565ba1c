// Reads a CSV file once and prints how long it took; bench/csv_reader.py compares this with pandas.
//
//   csv_reader FILE table|file [DUMP]    table: one thread, no checksum; file: as users read, with SHA-256 beside
//
// DUMP receives the samples of every channel in SI, one channel after the other, as binary64.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>

#include "tumble/formats/csv/read.hpp"
#include "tumble/units/error.hpp"

int main(int count, char** arguments) {
  if (count < 3) return 2;
  const std::string path = arguments[1];
  const bool alone = std::strcmp(arguments[2], "table") == 0;
  try {
    const auto wall = std::chrono::steady_clock::now();
    const auto cpu = std::clock();
    const auto recording = alone ? tumble::csv::read_table(path, {}, {}) : tumble::read_recording(path, {}, {});
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - wall;
    std::printf("%.6f %.6f\n", seconds.count(), static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
    if (count < 4) return 0;
    std::ofstream dump(arguments[3], std::ios::binary);
    for (const auto& channel : recording.channels)
      dump.write(reinterpret_cast<const char*>(channel.values.data()),
                 static_cast<std::streamsize>(channel.values.size() * sizeof(double)));
    return dump.good() ? 0 : 1;
  } catch (const tumble::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
