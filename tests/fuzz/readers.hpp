#pragma once

#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fuzz {

/// Empty, or what is wrong.
inline std::string wrong_with(const Recording& recording) {
  for (const Channel& channel : recording.channels) {
    if (!channel.timeline.uniform() && channel.timeline.stamps->size() != channel.values.size())
      return "stamps do not fit the samples of " + channel.name;
    if (channel.timeline.uniform() && !(channel.timeline.rate > 0.0)) return "no rate in " + channel.name;
    for (const double value : channel.values)
      if (std::isinf(value)) return "infinite sample in " + channel.name;
  }
  return "";
}

template <typename Action>
std::string outcome(Action action) {
  try {
    return action();
  } catch (const Error& error) {
    return error.kind == Error::Kind::bad_file && error.what()[0] != '\0'
               ? ""
               : "an Error of the wrong kind: " + std::string(error.what());
  } catch (const std::exception& other) {
    return "not an Error: " + std::string(other.what());
  }
}

/// Reads `bytes` as a recording through every reader, whole and in blocks. Anything but a Recording or an Error with a
/// message is a defect: an exception of another kind, a sample that is infinite, a timeline that does not fit.
/// Returned  empty, or what is wrong
inline std::string read_hostile(std::string_view bytes, const std::string& path) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ReadOptions options;
  if (bytes.size() % 2 == 0) options.rate = 100.0;
  if (bytes.size() % 3 == 0) options.columns = {"time[s]", "a[1]", "-"};
  if (bytes.size() % 5 == 0) options.segment_column = "a";
  for (const Format* format : format_catalogue()) {
    const auto whole = outcome([&] { return wrong_with(format->read(path, options, {})); });
    if (!whole.empty()) return std::string(format->name) + ": " + whole;
    const auto streamed = outcome([&] {
      std::string wrong;
      stream_recording(*format, path, options, 64,
                       [&](const Recording& block) {
                         if (wrong.empty()) wrong = wrong_with(block);
                       },
                       {});
      return wrong;
    });
    if (!streamed.empty()) return std::string(format->name) + " stream: " + streamed;
  }
  return "";
}

}  // namespace tumble::fuzz
