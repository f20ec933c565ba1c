// Recordings of the app Sensor Logger for Android and iOS: a folder, or a zip archive of it, with a CSV file for each
// sensor. Columns: time [ns] since 1970, seconds_elapsed, z, y, x.

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/read.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/temporary_file.hpp"
#include "tumble/formats/file/text_lines.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/zip/archive.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

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
    if (std::ranges::find(known, topic) == known.end()) {
      std::string list;
      for (const auto& one : known) list += (list.empty() ? "" : ", ") + one;
      throw Error{Error::Kind::bad_file,
                  "'" + path + "' has no sensor '" + topic + "'" + did_you_mean(topic, known) + "; it has " + list};
    }
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
    throw Error{
        Error::Kind::bad_file,
        "'" + path + "' has no sensor that is read without being asked for; pick one: --topic " + known.front()};
  return names;
}

/// The channels x, y, z of one file, on the clock of the file, and the first stamp [ns].
struct SensorData {
  std::vector<Channel> channels;
  std::int64_t begin = 0;
  std::string checksum;
};

SensorData data_of(const std::string& path, const Source& source, const std::string& name, bool in_g,
                   const Progress& progress) {
  const Sensor& sensor = *sensor_named(name);
  const SensorFile file(path, source, name);
  ReadOptions options;
  options.time = "time";
  options.only = {"x", "y", "z"};
  const Unit unit = Unit::parse(in_g && std::string_view(sensor.unit) == "m/s^2" ? "g" : sensor.unit);
  for (const auto& axis : options.only) options.units[axis] = unit;
  SensorData data;
  Recording recording;
  try {
    recording = csv::read_table(file.path(), options, progress);
  } catch (const Error& error) {
    auto problems = error.problems;
    std::erase_if(problems, [](const std::string& problem) { return problem.starts_with("to copy"); });
    for (auto& problem : problems)
      if (const auto at = problem.find(file.path()); at != std::string::npos)
        problem.replace(at, file.path().size(), path + ": " + name + ".csv");
    throw Error(error.kind, problems);
  }
  data.begin = parse_iso_time(recording.meta[clock_start]).value_or(data.begin);
  for (const char* axis : {"x", "y", "z"})
    for (Channel& channel : recording.channels)
      if (channel.name == axis) {
        channel.name = name + "." + axis;
        data.channels.push_back(std::move(channel));
      }
  data.checksum = source.folder ? sha256_of_file(file.path()) : "";
  return data;
}

/// Moves the timeline to a clock that begins earlier. Given: by [s]. Channels share their stamps.
void shift(std::vector<Channel>& channels, double by) {
  std::map<const void*, std::shared_ptr<const std::vector<double>>> moved;
  for (Channel& channel : channels) {
    channel.timeline.start += by;
    if (channel.timeline.uniform()) continue;
    auto& stamps = moved[channel.timeline.stamps.get()];
    if (!stamps) {
      auto later = *channel.timeline.stamps;
      for (double& stamp : later) stamp += by;
      stamps = std::make_shared<const std::vector<double>>(std::move(later));
    }
    channel.timeline.stamps = stamps;
  }
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const auto& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
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

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  Source source = source_of(path);
  if (!source.ours())
    throw Error{
        Error::Kind::bad_file,
        "'" + path +
            "' is not a recording of Sensor Logger: Metadata.csv and a file such as Gyroscope.csv are expected"};
  const auto empty = leave_empty(path, source);
  if (!source.ours()) throw Error{Error::Kind::bad_file, "'" + path + "' has no samples of " + joined(empty)};
  Recording recording;
  if (!empty.empty())
    recording.findings.push_back({Finding::Severity::info, "sensors_empty", {{"sensors", joined(empty)}}, path});
  recording.meta = metadata_of(path, source);
  const bool in_g = recording.meta["platform"] == "ios" && recording.meta["standardisation"] == "false";
  const auto names = chosen(path, source, options);
  std::vector<SensorData> data;
  std::string checksums;
  for (const auto& name : names) {
    data.push_back(data_of(path, source, name, in_g, progress));
    checksums += data.back().checksum + "  " + name + ".csv\n";
  }
  const std::int64_t begin = std::ranges::min_element(data, {}, &SensorData::begin)->begin;
  for (SensorData& one : data) {
    shift(one.channels, static_cast<double>(one.begin - begin) * 1e-9);
    for (Channel& channel : one.channels)
      if (options.only.empty() || std::ranges::find(options.only, channel.name) != options.only.end())
        recording.channels.push_back(std::move(channel));
  }
  if (recording.channels.empty())
    throw Error{Error::Kind::bad_file, "'" + path + "' has none of the channels " + joined(options.only)};
  recording.meta[clock_start] = iso_time(begin) + "Z";
  say_choice(recording, source, names, path);
  recording.origin.file = path;
  if (source.folder)
    recording.origin.checksum = [sum = sha256_of(checksums)] { return sum; };
  else
    recording.origin.checksum = sha256_in_background(path);
  return recording;
}

}  // namespace

extern const Format sensor_logger{.name = "sensor_logger",
                                  .summary = "folder or zip archive of the app Sensor Logger, a file for each sensor",
                                  .extensions = {".sensorlogger"},
                                  .recognises = recognises,
                                  .read = tumble::sensor_logger::read,
                                  .folders = true};

}  // namespace tumble::sensor_logger
