// Recordings of the app Sensor Logger for Android and iOS: a folder, or a zip archive of it, with a CSV file for each
// sensor. Columns: time [ns] since 1970, seconds_elapsed, z, y, x.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/read.hpp"
#include "tumble/formats/file/gathered.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/temporary_file.hpp"
#include "tumble/formats/file/text_lines.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/zip/archive.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::sensor_logger {

namespace {

namespace fs = std::filesystem;

/// A file of the app, and what it holds.
struct Sensor {
  const char* name;
  const char* kind;  ///< of several files of one kind the first is read
  const char* unit;
  const char* note;
};

/// Uncalibrated before calibrated: a calibration needs what the sensor gives. The accelerometer without gravity is read
/// only where it is asked for.
constexpr Sensor sensors[] = {
    {"GyroscopeUncalibrated", "gyroscope", "rad/s", "as the sensor gives it"},
    {"Gyroscope", "gyroscope", "rad/s", "corrected by the phone"},
    {"AccelerometerUncalibrated", "accelerometer", "m/s^2", "as the sensor gives it"},
    {"TotalAcceleration", "accelerometer", "m/s^2", "with gravity, corrected by the phone"},
    {"Accelerometer", "", "m/s^2", "without gravity"},
    {"MagnetometerUncalibrated", "magnetometer", "uT", "as the sensor gives it"},
    {"Magnetometer", "magnetometer", "uT", "corrected by the phone"},
    {"Gravity", "", "m/s^2", "calculated by the phone"},
};

const Sensor* sensor_named(const std::string& name) {
  for (const Sensor& sensor : sensors)
    if (name == sensor.name) return &sensor;
  return nullptr;
}

/// The CSV files of a folder or archive by their names without ".csv".
struct Source {
  bool folder = false;
  std::map<std::string, std::string> paths;   ///< in a folder
  std::map<std::string, zip::Entry> entries;  ///< in an archive

  bool has(const std::string& name) const { return paths.contains(name) || entries.contains(name); }
  bool ours() const {
    return has("Metadata") && std::ranges::any_of(sensors, [&](const Sensor& one) { return has(one.name); });
  }
};

Source source_of(const std::string& path) {
  Source source;
  std::error_code problem;
  source.folder = fs::is_directory(path, problem);
  const auto stem = [](const fs::path& file) { return file.extension() == ".csv" ? file.stem().string() : ""; };
  if (source.folder) {
    for (fs::directory_iterator file(path, problem), end; !problem && file != end; file.increment(problem))
      if (const auto name = stem(file->path()); !name.empty()) source.paths[name] = file->path().string();
  } else {
    for (const zip::Entry& entry : zip::entries_of(path))
      if (const auto name = stem(fs::path(entry.name)); !name.empty()) source.entries.emplace(name, entry);
  }
  return source;
}

bool recognises(const std::string& path) {
  std::error_code problem;
  try {
    return (fs::is_directory(path, problem) || zip::is_archive(path)) && source_of(path).ours();
  } catch (const Error&) {
    return false;
  }
}

/// One CSV file, in the folder or unpacked from the archive.
class SensorFile {
 public:
  SensorFile(const std::string& path, const Source& source, const std::string& name) {
    if (source.folder) {
      path_ = source.paths.at(name);
      return;
    }
    const zip::Entry& entry = source.entries.at(name);
    copy_ = std::make_unique<file::TemporaryFile>(entry.name, path);
    zip::unpack(path, entry, [&](std::string_view bytes) { copy_->write(bytes); });
    copy_->close();
    path_ = copy_->path();
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::unique_ptr<file::TemporaryFile> copy_;
};

/// Names and values of the one row of Metadata.csv.
std::map<std::string, std::string> metadata_of(const std::string& path, const Source& source) {
  const SensorFile file(path, source, "Metadata");
  std::vector<std::vector<std::string>> rows;
  file::each_line(file.path(), "", {}, [&](std::string_view line, std::size_t) {
    if (rows.size() < 2) rows.push_back(csv::cells_of(line, ','));
  });
  std::map<std::string, std::string> metadata;
  if (rows.size() == 2)
    for (std::size_t i = 0; i < std::min(rows[0].size(), rows[1].size()); ++i)
      if (!rows[0][i].empty()) metadata[rows[0][i]] = rows[1][i];
  return metadata;
}

/// Whether a file has rows: the app writes a header alone where the phone has no such sensor, or may not read it.
bool has_rows(const std::string& path, const Source& source, const std::string& name) {
  constexpr std::uintmax_t headers_only = 512;  // bytes: a header is shorter
  std::error_code problem;
  if ((source.folder ? fs::file_size(source.paths.at(name), problem) : source.entries.at(name).size) > headers_only)
    return true;
  const SensorFile file(path, source, name);
  std::size_t lines = 0;
  file::each_line(file.path(), "", {},
                  [&](std::string_view line, std::size_t) { lines += lines < 2 && !csv::trimmed(line).empty(); });
  return lines > 1;
}

/// Leaves out the sensors whose files are empty; their names.
std::vector<std::string> leave_empty(const std::string& path, Source& source) {
  std::vector<std::string> empty;
  for (const Sensor& sensor : sensors) {
    if (!source.has(sensor.name) || has_rows(path, source, sensor.name)) continue;
    empty.emplace_back(sensor.name);
    source.paths.erase(sensor.name);
    source.entries.erase(sensor.name);
  }
  return empty;
}

/// Those asked for; else the first of each kind.
std::vector<std::string> chosen(const std::string& path, const Source& source, const ReadOptions& options) {
  std::vector<std::string> names, known;
  for (const Sensor& sensor : sensors)
    if (source.has(sensor.name)) known.emplace_back(sensor.name);
  for (const std::string& topic : options.topics) {
    if (std::ranges::find(known, topic) == known.end())
      throw Error{Error::Kind::bad_file, say("'{}' has no sensor '{}'{}; it has {}", path, topic,
                                             did_you_mean(topic, known), fmt::join(known, ", "))};
    names.push_back(topic);
  }
  if (!names.empty()) return names;
  std::vector<std::string> kinds;
  for (const std::string& name : known) {
    const std::string kind = sensor_named(name)->kind;
    if (kind.empty() || std::ranges::find(kinds, kind) != kinds.end()) continue;
    kinds.push_back(kind);
    names.push_back(name);
  }
  if (names.empty())
    throw Error{Error::Kind::bad_file,
                say("'{}' has no sensor that is read without being asked for; pick one: --topic {}", path,
                    Name{known.front()})};
  return names;
}

constexpr std::size_t samples_at_once = 65536;

/// The channels x, y, z of one file, on the clock of the file, and the first stamp [ns].
struct SensorData {
  file::Gathered table;
  std::int64_t begin = 0;
  std::string checksum;
};

/// Joins the blocks of a table, whose channels share one clock. `turned`: the values change their sign.
class Joiner {
 public:
  Joiner(file::Gathered& to, std::shared_ptr<file::Spool> spool, bool turned)
      : to_(to), spool_(std::move(spool)), turned_(turned) {}

  void take(const Recording& block) {
    if (to_.sources.empty()) begin(block);
    for (std::size_t i = 0; i < block.channels.size(); ++i) {
      std::vector<double> values = block.channels[i].values;
      if (turned_) std::ranges::transform(values, values.begin(), std::negate<>());
      to_.sources[i].values->add(values.data(), values.size());
    }
    const auto& stamps = block.channels.front().timeline.stamps;
    if (stamps) stamps_->add(stamps->data(), stamps->size());
  }

 private:
  void begin(const Recording& block) {
    to_.frame.meta = block.meta;
    if (!block.channels.front().timeline.uniform()) stamps_ = std::make_shared<file::Series>(spool_);
    for (const Channel& channel : block.channels) {
      const Timeline even{channel.timeline.start, channel.timeline.rate, nullptr};
      to_.frame.channels.push_back({channel.name, channel.kind, channel.unit, even, {}});
      to_.sources.push_back({.values = std::make_shared<file::Series>(spool_), .stamps = stamps_, .in_si = true});
    }
  }

  file::Gathered& to_;
  std::shared_ptr<file::Spool> spool_;
  bool turned_;
  std::shared_ptr<file::Series> stamps_;
};

/// Accelerations, with or without gravity.
bool is_force(const Sensor& sensor) { return std::string_view(sensor.unit) == "m/s^2"; }

/// iOS counts accelerations with the opposite sign, and those that it did not correct in g, unless the app was asked to
/// write both platforms alike.
bool by_ios(const Recording& recording) {
  const auto said = [&](const char* key) {
    const auto found = recording.meta.find(key);
    return found == recording.meta.end() ? "" : found->second;
  };
  return said("platform") == "ios" && said("standardisation") != "true";
}

SensorData data_of(const std::string& path, const Source& source, const std::string& name, bool ios,
                   std::optional<double> rate, const std::shared_ptr<file::Spool>& spool, const Progress& progress) {
  const Sensor& sensor = *sensor_named(name);
  const SensorFile file(path, source, name);
  ReadOptions options;
  options.time = "time";
  options.rate = rate;
  options.only = {"x", "y", "z"};
  const Unit unit = Unit::parse(ios && name == "AccelerometerUncalibrated" ? "g" : sensor.unit);
  for (const auto& axis : options.only) options.units[axis] = unit;
  SensorData data;
  Joiner joiner(data.table, spool, ios && is_force(sensor));
  try {
    csv::stream(
        file.path(), options, samples_at_once, [&](const Recording& block) { joiner.take(block); }, progress);
  } catch (const Error& error) {
    auto problems = error.problems;
    std::erase_if(problems, [](const Problem& problem) { return problem.what.pattern.starts_with("to copy"); });
    for (auto& problem : problems)
      problem = with_values(
          problem, [&](const std::string& text) { return text == file.path() ? path + ": " + name + ".csv" : text; });
    throw Error(error.kind, problems);
  }
  data.begin = parse_iso_time(data.table.frame.meta[clock_start]).value_or(data.begin);
  data.checksum = source.folder ? sha256_of_file(file.path()) : "";
  return data;
}

/// Moves the channels x, y, z of sensor `name` that are wanted to `all`, on a clock that begins earlier by `later` [s].
void move_channels(SensorData& data, const std::string& name, double later, const ReadOptions& options,
                   file::Gathered& all) {
  const auto& channels = data.table.frame.channels;
  for (const char* axis : {"x", "y", "z"}) {
    const std::string full = name + "." + axis;
    const auto found = std::ranges::find(channels, axis, &Channel::name);
    const bool wanted = options.only.empty() || std::ranges::find(options.only, full) != options.only.end();
    if (found == channels.end() || !wanted) continue;
    all.frame.channels.push_back(*found);
    all.frame.channels.back().name = full;
    all.frame.channels.back().timeline.start += later;
    all.sources.push_back(data.table.sources[static_cast<std::size_t>(found - channels.begin())]);
    all.sources.back().begin = later;
  }
}

void say_choice(Recording& recording, const Source& source, const std::vector<std::string>& names,
                const std::string& path) {
  std::vector<std::string> read, others;
  for (const Sensor& sensor : sensors) {
    if (!source.has(sensor.name)) continue;
    const bool is_read = std::ranges::find(names, sensor.name) != names.end();
    (is_read ? read : others).push_back(std::string(sensor.name) + " (" + sensor.note + ")");
  }
  recording.recognised = {
      {"clock", "time in ns since 1970"}, {"order", "columns z, y, x by their names"}, {"read", joined(read)}};
  if (others.empty()) return;
  recording.recognised.push_back({"not read", joined(others)});
  recording.findings.push_back(
      {Finding::Severity::info, "sensors_not_read", {{"read", joined(read)}, {"others", joined(others)}}, path});
}

/// The sensors with samples. Throws Error::bad_file; adds a finding that names those without.
Source opened(const std::string& path, Findings& findings) {
  Source source = source_of(path);
  if (!source.ours())
    throw Error{
        Error::Kind::bad_file,
        say("'{}' is not a recording of Sensor Logger: Metadata.csv and a file such as Gyroscope.csv are expected",
            path)};
  const auto empty = leave_empty(path, source);
  if (!source.ours())
    throw Error{Error::Kind::bad_file, say("'{}' has no samples of {}", path, fmt::join(empty, ", "))};
  if (!empty.empty())
    findings.push_back({Finding::Severity::info, "sensors_empty", {{"sensors", joined(empty)}}, path});
  return source;
}

file::Gathered gather(const std::string& path, const ReadOptions& options, const std::shared_ptr<file::Spool>& spool,
                      const Progress& progress) {
  file::Gathered all;
  Recording& recording = all.frame;
  const Source source = opened(path, recording.findings);
  recording.meta = metadata_of(path, source);
  const bool ios = by_ios(recording);
  const auto names = chosen(path, source, options);
  std::vector<SensorData> data;
  std::string checksums;
  for (const auto& name : names) {
    data.push_back(data_of(path, source, name, ios, options.rate, spool, progress));
    checksums += data.back().checksum + "  " + name + ".csv\n";
  }
  const std::int64_t begin = std::ranges::min_element(data, {}, &SensorData::begin)->begin;
  for (std::size_t i = 0; i < data.size(); ++i)
    move_channels(data[i], names[i], static_cast<double>(data[i].begin - begin) * 1e-9, options, all);
  if (recording.channels.empty())
    throw Error{Error::Kind::bad_file, say("'{}' has none of the channels {}", path, fmt::join(options.only, ", "))};
  recording.meta[clock_start] = iso_time(begin) + "Z";
  if (ios && std::ranges::any_of(names, [](const std::string& name) { return is_force(*sensor_named(name)); }))
    recording.findings.push_back({Finding::Severity::info, "accelerations_of_ios", {}, path});
  say_choice(recording, source, names, path);
  recording.origin.file = path;
  if (source.folder) recording.origin.checksum = [sum = sha256_of(checksums)] { return sum; };
  return all;
}

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  Recording recording = file::in_memory(gather(path, options, nullptr, progress));
  if (!recording.origin.checksum) recording.origin.checksum = sha256_in_background(path);
  return recording;
}

/// A row has about 70 bytes, and 32 of them are needed for its numbers.
std::uintmax_t memory(const std::string& path, const ReadOptions& options) {
  Findings ignored;
  const Source source = opened(path, ignored);
  std::uintmax_t bytes = 0;
  for (const auto& name : chosen(path, source, options))
    bytes += source.folder ? fs::file_size(source.paths.at(name)) : source.entries.at(name).size;
  return bytes / 2;
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  const auto gathered = gather(path, options, std::make_shared<file::Spool>(path), progress);
  file::hand_out(gathered, samples, sink, progress);
}

}  // namespace

extern const Format sensor_logger{.name = "sensor_logger",
                                  .summary = "folder or zip archive of the app Sensor Logger, a file for each sensor",
                                  .extensions = {".sensorlogger"},
                                  .recognises = recognises,
                                  .read = tumble::sensor_logger::read,
                                  .memory = memory,
                                  .stream = stream,
                                  .folders = true};

}  // namespace tumble::sensor_logger
