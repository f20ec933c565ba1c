// Decodes streams of shipped declarations and prints MB and million frames a second of processor time
// (bench/results/frames.md).
//
//   frames [FOLDER]     the folder for a file of 100 MB; default: here
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"
#include "tumble/wire/instruments.hpp"

namespace {

constexpr std::size_t size = 100'000'000;

/// A stream of one layout; every channel without a condition is present, items of the first number format only.
std::string stream_of(const tumble::FrameCodec& codec, const std::string& layout, std::size_t bytes) {
  tumble::FrameContent content;
  while (codec.frames[content.frame].name != layout) ++content.frame;
  for (const auto& channel : codec.channels) content.values.push_back(channel.name.starts_with("temp") ? 293.15 : 0.0);
  content.present.resize(codec.channels.size());
  for (const auto& field : codec.frames[content.frame].fields)
    if (!field.when) content.present[field.channel] = 1;
  const auto& counter = codec.frames[content.frame].counter;
  std::string stream;
  for (std::uint64_t i = 0; stream.size() < bytes; ++i) {
    if (counter) content.counter = i % counter->modulus;
    content.time = 0.001 * static_cast<double>(i);
    stream += encode_frame(codec, content);
  }
  return stream;
}

template <class Work>
double seconds_of(Work work) {
  const auto begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

void measure(const char* name, const char* layout, const std::string& file) {
  const auto codec = tumble::codec_of(tumble::find_instrument(name));
  const std::string stream = stream_of(codec, layout, size);
  std::ofstream(file, std::ios::binary) << stream;
  const double megabytes = static_cast<double>(stream.size()) / 1e6;
  std::uint64_t frames = 0;
  const double decode = seconds_of([&] {
    tumble::FrameStream decoder(codec);
    for (std::size_t at = 0; at < stream.size(); at += 1 << 20)
      decoder.feed(std::string_view(stream).substr(at, 1 << 20), [&](const tumble::StreamFrame&) { ++frames; });
  });
  tumble::ReadOptions options;
  options.rate = 1000.0;
  const double recognise = seconds_of([&] { tumble::format_of(file); });
  const double read = seconds_of([&] { tumble::read_recording(file, options, {}); });
  const double blocks = seconds_of([&] {
    tumble::stream_recording(tumble::format_of(file), file, options, 65536, [](const tumble::Recording&) {}, {});
  });
  std::printf("| %s, %s | %.0f | %.2f | %.0f | %.0f | %.0f |\n", name, layout, megabytes / decode,
              static_cast<double>(frames) / decode / 1e6, megabytes / read, megabytes / blocks, 1e3 * recognise);
}

}  // namespace

int main(int count, char** arguments) try {
  const std::string file = std::string(count > 1 ? arguments[1] : ".") + "/frames.raw";
  const double shipped = seconds_of([] { tumble::shipped_instruments(); });
  std::printf(
      "shipped declarations read in %.0f ms\n\n| stream | decode [MB/s] | million frames a second | read with SHA-256 "
      "[MB/s] | "
      "in blocks, two passes [MB/s] | recognise [ms] |\n|---|---|---|---|---|---|\n",
      1e3 * shipped);
  measure("kvh_1775", "B", file);
  measure("stim300", "93", file);
  measure("microstrain_mip", "sensor data", file);
  measure("sbg_ecom", "IMU_SHORT", file);
  std::filesystem::remove(file);
} catch (const tumble::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 3;
}
