#include "tumble/formats/format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/conflicts.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/unread.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

constexpr std::size_t block_samples = 65536;

const Format* by_extension(const std::string& path, const FormatList& formats) {
  for (const Format* format : formats)
    for (const std::string& extension : format->extensions)
      if (path.size() > extension.size() &&
          std::equal(extension.rbegin(), extension.rend(), path.rbegin(),
                     [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); }))
        return format;
  return nullptr;
}

/// ".csv, .txt" of the formats that `which` selects.
template <class Which>
std::string extensions(const FormatList& formats, Which which) {
  std::string text;
  for (const Format* format : formats)
    if (which(*format))
      for (const std::string& extension : format->extensions) text += (text.empty() ? "" : ", ") + extension;
  return text;
}

bool can_be_written(const Format& format) { return format.writer != nullptr; }

/// "csv (.csv, .txt), hdf5 (.h5)"
std::string written_formats(const FormatList& formats) {
  std::string text;
  for (const Format* format : formats)
    if (can_be_written(*format))
      text +=
          (text.empty() ? "" : ", ") + std::string(format->name) + " (" + extensions({format}, can_be_written) + ")";
  return text;
}

/// No instrument samples that fast or that slowly, and no test takes that long: the time is in another unit, or the
/// column is not the time.
void refuse_impossible_clocks(const Recording& recording, const std::string& path) {
  constexpr double year = 8766.0 * hour;
  constexpr double fastest = 1e10, slowest = 1.0 / year;  // Hz
  constexpr double last = 1e6 * year;                     // some clocks begin with the calendar
  Problems problems;
  for (const auto& channel : recording.channels)
    if (const double rate = mean_rate(channel); rate > fastest)
      problems.push_back(
          say("'{}': channel '{}' has {:.2g} samples a second: in which unit is the time?", path, channel.name, rate));
    else if (channel.values.size() > 1 && rate > 0.0 && rate < slowest)
      problems.push_back(say("'{}': the samples of channel '{}' are {:.2g} s apart: in which unit is the time?", path,
                             channel.name, 1.0 / rate));
    else if (const std::size_t size = channel.values.size();
             size > 0 && !std::isfinite(channel.timeline.time(size - 1)))
      problems.push_back(
          say("'{}': the time of the last sample of channel '{}' is no number of a computer: in which "
              "unit is the time?",
              path, channel.name));
  for (const Mark& mark : recording.marks)
    if (std::abs(mark.begin) > last)
      problems.push_back(
          say("'{}': the mark '{}' is at {:.2g} s: in which unit is its time?", path, mark.label, mark.begin));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace

const Format& format_of(const std::string& path, const FormatList& formats) {
  std::error_code unknown;
  if (std::filesystem::is_directory(path, unknown))
    for (const Format* format : formats)
      if (format->folders && format->recognises(path)) return *format;
  if (file::InputFile(path).size() == 0) throw Error{Error::Kind::bad_file, say("'{}' is empty", path)};
  if (const auto advice = file::advice_for_other_kind(path); !advice.empty())
    throw Error{Error::Kind::bad_file, say("'{}' is {}", path, advice)};
  for (const bool last : {false, true})
    for (const Format* format : formats)
      if (format->asked_last == last && format->recognises(path)) return *format;
  if (const auto advice = file::advice_for_unread(path); !advice.empty())
    throw Error{Error::Kind::bad_file, say("'{}' is {}", path, advice)};
  if (const Format* format = by_extension(path, formats)) return *format;
  throw Error{Error::Kind::bad_file,
              say("'{}' is not a recording that can be read: neither its content nor its name says which; known are {}",
                  path, Name{extensions(formats, [](const Format&) { return true; })})};
}

const Format& format_of(const std::string& path, const ReadOptions& options, const FormatList& formats) {
  if (options.frames.empty()) return format_of(path, formats);
  if (file::InputFile(path).size() == 0) throw Error{Error::Kind::bad_file, say("'{}' is empty", path)};
  for (const std::string_view packed : {"gzip", "zip"})
    for (const Format* format : formats)
      if (packed == format->name && format->recognises(path)) return *format;
  const auto raw = std::ranges::find(formats, std::string_view("frames"), &Format::name);
  if (raw == formats.end()) throw Error{Error::Kind::unsupported, "files of raw bytes are not read here"};
  return **raw;
}

const Format& format_to_write(const std::string& path, const FormatList& formats) {
  const Format* format = by_extension(path == standard_output ? "stream.csv" : path, formats);
  if (!format)
    throw Error{Error::Kind::bad_input, say("'{}': the name must say which format to write; known are {}", path,
                                            Name{extensions(formats, can_be_written)})};
  if (!can_be_written(*format))
    throw Error{Error::Kind::bad_input,
                say("'{}': files of format {} are read, but cannot be written; the formats that can be written are {}",
                    path, format->name, Name{written_formats(formats)})};
  return *format;
}

Recording read_recording(const std::string& path, const ReadOptions& options, const Progress& progress,
                         const FormatList& formats) {
  Recording recording = format_of(path, options, formats).read(path, options, progress);
  refuse_impossible_clocks(recording, path);
  for (Channel& channel : recording.channels)  // the stated rate decides where stamps do not
    if (!channel.timeline.uniform()) channel.timeline.rate = options.rate.value_or(0.0);
  return recording;
}

RecordingWriter recording_writer(const std::string& path, const FormatList& formats) {
  return format_to_write(path, formats).writer(path);
}

void write_recording(const Recording& recording, const std::string& path, const FormatList& formats) {
  const RecordingWriter writer = recording_writer(path, formats);
  writer.append(recording);
  writer.commit();
}

void convert(const std::string& from, const std::string& to, const ReadOptions& options, const Progress& progress,
             const FormatList& formats) {
  const Format& source = format_of(from, options, formats);
  const RecordingWriter writer = recording_writer(to, formats);
  bool first = true;
  const auto checked = [&](const Recording& block) {
    if (std::exchange(first, false)) refuse_conflicts(block, options);
    writer.append(block);
  };
  stream_recording(source, from, options, block_samples, checked, progress);
  writer.commit();
}

}  // namespace tumble
