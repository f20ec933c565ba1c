#include <algorithm>
#include <filesystem>
#include <string_view>

#include "tumble/tasks/stream_recording.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble::tasks {
namespace {

constexpr std::size_t block_samples = 1 << 20;

const Format* by_extension(const std::string& path) {
  const auto extension = std::filesystem::path(path).extension().string();
  for (const auto* format : formats::catalogue())
    if (std::find(format->extensions.begin(), format->extensions.end(), extension) != format->extensions.end())
      return format;
  return nullptr;
}

}  // namespace

void stream_recording(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
                      const Progress& progress) {
  const Format* found = nullptr;
  for (const auto* format : formats::catalogue())
    if (!found && format->recognises(path)) found = format;
  if (!found) found = by_extension(path);
  if (!found) throw Error(Error::Kind::bad_file, path + ": no format that is known here");
  found->stream(path, options, samples, sink, progress);
}

void convert(const std::string& path, const std::string& output, const ReadOptions& options, const Progress& progress) {
  const auto* format = by_extension(output);
  if (!format || !format->writer)
    throw Error(Error::Kind::bad_input, output + ": the ending of the name says no format that can be written");
  const auto writer = format->writer(output);
  stream_recording(path, options, block_samples, writer.append, progress);
  writer.commit();
}

}  // namespace tumble::tasks
