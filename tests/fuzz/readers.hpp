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

/// What `action` returns; an Error of kind `expected` with a message is no defect, everything else that is thrown is.
template <typename Action>
std::string outcome(Action action, Error::Kind expected = Error::Kind::bad_file) {
  try {
    return action();
  } catch (const Error& error) {
    return error.kind == expected && error.what()[0] != '\0'
               ? ""
               : "an Error of the wrong kind: " + std::string(error.what());
  } catch (const std::exception& other) {
    return "not an Error: " + std::string(other.what());
  }
}

/// What the user may say of a file, drawn from its size.
inline ReadOptions some_options(std::size_t size) {
  ReadOptions options;
  if (size % 2 == 0) options.rate = 100.0;
  if (size % 3 == 0) options.columns = {"time[s]", "a[1]", "-"};
  if (size % 5 == 0) options.segment_column = "a";
  return options;
}

/// Reads the file as a recording of one format, whole and in blocks of `samples` [1]. Anything but a Recording or an
/// Error with a message is a defect: an exception of another kind, a sample that is infinite, a timeline that does not
/// fit. Returned empty, or what is wrong
inline std::string read_hostile_as(const Format& format, const std::string& path, const ReadOptions& options,
                                   std::size_t samples = 64) {
  const auto recognised = outcome([&] {
    static_cast<void>(format.recognises(path));
    return "";
  });
  if (!recognised.empty()) return std::string(format.name) + " recognises: " + recognised;
  const auto whole = outcome([&] { return wrong_with(format.read(path, options, {})); });
  if (!whole.empty()) return std::string(format.name) + ": " + whole;
  const auto streamed = outcome([&] {
    std::string wrong;
    stream_recording(format, path, options, samples,
                     [&](const Recording& block) {
                       if (wrong.empty()) wrong = wrong_with(block);
                     },
                     {});
    return wrong;
  });
  if (!streamed.empty()) return std::string(format.name) + " stream: " + streamed;
  const auto asked = outcome([&] {
    static_cast<void>(recording_memory(format, path, options));
    return "";
  });
  return asked.empty() ? "" : std::string(format.name) + " memory: " + asked;
}

inline void write_bytes(std::string_view bytes, const std::string& path) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// The same through every reader.
inline std::string read_hostile(std::string_view bytes, const std::string& path) {
  write_bytes(bytes, path);
  for (const Format* format : format_catalogue())
    if (const auto wrong = read_hostile_as(*format, path, some_options(bytes.size())); !wrong.empty()) return wrong;
  return "";
}

}  // namespace tumble::fuzz
