// LabVIEW Measurement file, as National Instruments describes it: "Specification for the LabVIEW Measurement File
// (.lvm)". A header; then segments, each with a header of its own, a line of names and rows. With Multi_Headings = No
// only the first segment has a header.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <unordered_map>

#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/names.hpp"
#include "tumble/formats/csv/stamp.hpp"
#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/file/gathered.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/kinds_of_text.hpp"
#include "tumble/formats/file/text_lines.hpp"
#include "tumble/formats/file/unique_names.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

namespace tumble::lvm {

namespace {

constexpr std::string_view end_of_header = "***End_of_Header***";
constexpr csv::StampFormat date_and_time{csv::StampKind::date_time, csv::DateOrder::mdy, 1};

bool recognises(const std::string& path) {
  char bytes[64];
  return file::is_labview({bytes, file::InputFile(path).read(bytes, sizeof bytes)});
}

/// One signal over all segments.
struct Signal {
  std::string name, unit;
  std::shared_ptr<file::Series> times, values;  ///< [s], [as written]
  file::EvenClock clock = {};
  double last = 0.0;  ///< [s] of times
};

/// What the header of a segment says of a channel.
struct SegmentChannel {
  std::size_t signal = 0;
  std::size_t x = static_cast<std::size_t>(-1), y = 0;  ///< columns; no x: from start and step
  double start = 0.0, step = 0.0;                       ///< [s]
};

/// Reads line after line.
class Reader {
 public:
  /// `spool`: where the samples go; null: into memory.
  Reader(const std::string& path, const ReadOptions& options, std::shared_ptr<file::Spool> spool)
      : problems_(path), path_(path), options_(options), spool_(std::move(spool)) {}

  void take(std::string_view line, std::size_t number);
  file::Gathered finish();

 private:
  enum class Part { file_header, segment_header, names, rows, special };

  std::vector<std::string_view> cells(std::string_view line) const;
  void take_file_header(std::string_view line, std::size_t number);
  void take_segment_header(std::string_view line);
  void take_names(std::string_view line, std::size_t number);
  std::size_t signal_named(const std::string& written, const std::string& unit, std::size_t number);
  void check_dimension(std::size_t channel, std::size_t number);
  void take_row(std::string_view line, std::size_t number);
  void begin_segment();
  std::string said_of(const std::string& key, std::size_t channel) const;
  double number_said(const std::string& key, std::size_t channel, double otherwise) const;
  double seconds_later() const;
  void add_channel(file::Gathered& gathered, const Signal& signal, std::vector<std::string>& without_unit,
                   std::vector<Sentence>& strange) const;
  void complete(Recording& recording);

  Part part_ = Part::file_header, before_special_ = Part::rows;
  char separator_ = '\t', mark_ = '.';
  std::map<std::string, std::string> file_header_;
  std::map<std::string, std::vector<std::string>> header_;  ///< of the segment, by key
  std::vector<Signal> signals_;
  std::unordered_map<std::string, std::size_t> numbers_;  ///< of signals, by name
  file::UniqueNames names_;                               ///< of the segment
  std::vector<SegmentChannel> channels_;
  std::size_t row_ = 0, segments_ = 0, cut_line_ = 0, last_line_ = 0;
  std::string first_start_;
  double shift_ = 0.0;        ///< [s] added to the times of the segment
  bool shift_known_ = false;  ///< its first row was read
  bool shifted_ = false;
  file::Problems problems_;
  std::string path_;
  const ReadOptions& options_;
  std::shared_ptr<file::Spool> spool_;
};

std::vector<std::string_view> Reader::cells(std::string_view line) const {
  std::vector<std::string_view> result;
  for (;;) {
    const auto end = line.find(separator_);
    result.push_back(csv::trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return result;
    line.remove_prefix(end + 1);
  }
}

void Reader::take(std::string_view line, std::size_t number) {
  last_line_ = number;
  const std::string_view content = csv::trimmed(line);
  if (content.starts_with("***Start_Special***")) {
    before_special_ = part_;
    part_ = Part::special;
  } else if (part_ == Part::special) {
    if (content.starts_with("***End_Special***")) part_ = before_special_;
  } else if (part_ == Part::file_header) {
    take_file_header(line, number);
  } else if (part_ == Part::names) {
    if (!content.empty()) take_names(line, number);
  } else if (content.empty()) {
    if (part_ == Part::rows && cells(line).size() > channels_.size())
      ++row_;  // a row of missing samples takes its time
  } else if (part_ == Part::rows && !line.starts_with("Channels")) {
    take_row(line, number);
  } else {
    if (part_ == Part::rows) begin_segment();
    take_segment_header(line);
  }
}

void Reader::begin_segment() {
  part_ = Part::segment_header;
  header_.clear();
}

void Reader::take_file_header(std::string_view line, std::size_t number) {
  if (number == 1) return;
  if (csv::trimmed(line).starts_with(end_of_header)) return begin_segment();
  // The separator is one of the keys: until it is known, tab or comma behind the first word.
  const auto end = line.find_first_of("\t,");
  const std::string key(csv::trimmed(line.substr(0, end)));
  const std::string value(csv::trimmed(end == std::string_view::npos ? "" : line.substr(end + 1)));
  if (key == "Separator") separator_ = value.starts_with("Comma") ? ',' : '\t';
  if (key == "Decimal_Separator") mark_ = value.starts_with(',') ? ',' : '.';
  if (!key.empty()) file_header_[key] = value;
}

void Reader::take_segment_header(std::string_view line) {
  if (csv::trimmed(line).starts_with(end_of_header)) {
    part_ = Part::names;
    return;
  }
  const auto parts = cells(line);
  auto& values = header_[std::string(parts.front())];
  values.assign(parts.begin() + 1, parts.end());
}

std::string Reader::said_of(const std::string& key, std::size_t channel) const {
  const auto found = header_.find(key);
  if (found == header_.end()) return "";
  return channel < found->second.size() ? found->second[channel] : "";
}

double Reader::number_said(const std::string& key, std::size_t channel, double otherwise) const {
  double value = otherwise;
  return file::number_of(said_of(key, channel), mark_, value) ? value : otherwise;
}

/// Index in signals_. A name that stands twice in a segment becomes "ax_2".
std::size_t Reader::signal_named(const std::string& written, const std::string& unit, std::size_t number) {
  const std::string name = names_.take(written);
  const auto [found, is_new] = numbers_.emplace(name, signals_.size());
  if (is_new) {
    signals_.push_back({name, unit, std::make_shared<file::Series>(spool_), std::make_shared<file::Series>(spool_)});
    return found->second;
  }
  const Signal& known = signals_[found->second];
  if (!unit.empty() && !known.unit.empty() && known.unit != unit)
    problems_.add(number, say("channel '{}' is in '{}' here and in '{}' before", csv::plain_text(name, 40),
                              csv::plain_text(unit, 20), csv::plain_text(known.unit, 20)));
  return found->second;
}

/// A spectrum has frequencies where a time is expected.
void Reader::check_dimension(std::size_t channel, std::size_t number) {
  const std::string dimension = said_of("X_Dimension", channel);
  if (dimension.empty() || dimension == "Time") return;
  problems_.add(number, say("the X values are of dimension '{}': only Time is read", csv::plain_text(dimension, 40)));
}

/// Names of the columns; the channels of the segment are found again by name.
void Reader::take_names(std::string_view line, std::size_t number) {
  part_ = Part::rows;
  channels_.clear();
  names_ = {};
  row_ = 0;
  shift_known_ = false;
  ++segments_;
  const auto names = cells(line);
  const bool multi = file_header_["X_Columns"] == "Multi", none = file_header_["X_Columns"] == "No";
  std::size_t x = static_cast<std::size_t>(-1), order = 0;
  for (std::size_t column = 0; column < names.size(); ++column) {
    if (names[column] == "X_Value") {
      if (!none && (multi || column == 0)) x = column;
      continue;
    }
    if (names[column] == "Comment" || names[column].empty()) continue;
    SegmentChannel channel;
    channel.signal = signal_named(std::string(names[column]), said_of("Y_Unit_Label", order), number);
    check_dimension(order, number);
    channel.x = x;
    channel.y = column;
    channel.start = number_said("X0", order, 0.0);
    channel.step = number_said("Delta_X", order, 0.0);
    channels_.push_back(channel);
    ++order;
  }
}

/// [s] by which date and time of the segment are later than those of the first.
double Reader::seconds_later() const {
  const std::string start = said_of("Date", 0) + " " + said_of("Time", 0);
  csv::Stamp first, own;
  if (!csv::parse_stamp(first_start_, date_and_time, first) || !csv::parse_stamp(start, date_and_time, own)) return 0.0;
  return static_cast<double>(own.time - first.time) * 1e-9;
}

/// [s] One in the last digit of a time as written: 1e-6 of "0.000333".
double last_place(std::string_view number, char mark) {
  const auto e = std::min(number.find_first_of("eE"), number.size());
  const auto point = number.substr(0, e).find(mark);
  const auto digits = point == std::string_view::npos ? 0.0 : static_cast<double>(e - point - 1);
  const double power = e < number.size() ? std::atof(std::string(number.substr(e + 1)).c_str()) : 0.0;
  return std::pow(10.0, power - digits);
}

void Reader::take_row(std::string_view line, std::size_t number) {
  const auto parts = cells(line);
  const std::size_t row = row_++;
  std::size_t present = 0;
  for (const SegmentChannel& channel : channels_) {
    Signal& signal = signals_[channel.signal];
    double time = channel.start + static_cast<double>(row) * channel.step, value = 0.0;
    const bool timed = channel.x < parts.size() && !parts[channel.x].empty();
    if (timed && !file::number_of(parts[channel.x], mark_, time))
      problems_.add(number, say("'{}' is not a time", csv::plain_text(parts[channel.x], 40)));
    if (channel.y >= parts.size() || parts[channel.y].empty()) continue;  // a channel with fewer samples
    ++present;
    if (!timed && !(channel.step > 0.0 && channel.step < file::longest_step))
      problems_.add(number, say("channel '{}' has neither an X value nor a Delta_X that can be",
                                csv::plain_text(signal.name, 40)));
    if (!file::number_of(parts[channel.y], mark_, value)) {
      value = std::nan("");
      if (!csv::reads_like_missing(parts[channel.y]))
        problems_.add(number, say("'{}' is not a number", csv::plain_text(parts[channel.y], 40)));
    }
    if (!shift_known_) {  // times that begin again count from the date of their segment
      if (first_start_.empty()) first_start_ = said_of("Date", 0) + " " + said_of("Time", 0);
      shift_ = signal.times->size() > 0 && time <= signal.last ? seconds_later() : 0.0;
      shifted_ = shifted_ || shift_ != 0.0;
      shift_known_ = true;
    }
    signal.last = time + shift_;
    signal.times->add(signal.last);
    signal.clock.add(signal.last, timed ? last_place(parts[channel.x], mark_) : 0.0);
    signal.values->add(value);
  }
  if (present > 0 && present < channels_.size() && parts.size() <= channels_.back().y) cut_line_ = number;
}

void Reader::add_channel(file::Gathered& gathered, const Signal& signal, std::vector<std::string>& without_unit,
                         std::vector<Sentence>& strange) const {
  if (!options_.only.empty() && std::ranges::find(options_.only, signal.name) == options_.only.end()) return;
  Channel channel;
  channel.name = signal.name;
  const auto given = options_.units.find(signal.name);
  try {
    if (!signal.unit.empty())
      channel.unit = csv::parse_written_unit(signal.unit);
    else if (given != options_.units.end())
      channel.unit = given->second;
    else
      without_unit.push_back(signal.name);
  } catch (const Error& error) {
    if (given == options_.units.end()) {
      without_unit.push_back(signal.name);
      strange.push_back(say("'{}': {}", csv::plain_text(signal.name, 40), reason_of(error)));
      return;
    }
    channel.unit = given->second;
  }
  channel.kind = kind_of(channel.unit);
  const auto even = signal.clock.timeline(options_.rate);
  if (even) channel.timeline = *even;
  gathered.frame.channels.push_back(std::move(channel));
  gathered.sources.push_back({signal.values, even ? nullptr : signal.times});
}

file::Gathered Reader::finish() {
  if (part_ == Part::file_header || segments_ == 0)
    throw Error{Error::Kind::bad_file,
                say("'{}': a LabVIEW measurement file without the end of its header ({}); it was cut off", path_,
                    Name{std::string(end_of_header)})};
  file::Gathered gathered;
  std::vector<std::string> without_unit;
  std::vector<Sentence> strange;
  for (const Signal& signal : signals_) add_channel(gathered, signal, without_unit, strange);
  problems_.refuse_any();
  if (!without_unit.empty()) {
    std::vector<Sentence> names;
    std::string sets;
    for (const auto& name : without_unit) {
      names.push_back(say("'{}'", csv::plain_text(name, 60)));
      sets += " --set 'unit." + csv::plain_text(name, 60) + "=" + csv::likely_unit(name, 0.0) + "'";
    }
    const Sentence why = strange.empty() ? Sentence("the file has no Y_Unit_Label for them") : in_a_row(strange, "; ");
    throw Error{Error::Kind::bad_file,
                Problems{say("'{}': channels without a unit: {}; {}", path_, in_a_row(names, ", "), why),
                         say("to copy, with units to be checked: {}",
                             Name{"tumble inspect " + csv::shell_word(path_) + sets})}};
  }
  if (std::ranges::all_of(gathered.sources, [](const file::Source& one) { return one.values->size() == 0; }))
    throw Error{Error::Kind::bad_file, say("'{}' has no samples", path_)};
  complete(gathered.frame);
  return gathered;
}

/// What the file says of the test, and how it was read.
void Reader::complete(Recording& recording) {
  recording.origin.file = path_;
  for (const char* key : {"Operator", "Description", "Project", "Date", "Time"})
    if (!file_header_[key].empty()) recording.meta[key] = file_header_[key];
  if (csv::Stamp start; csv::allowed_orders(first_start_).plain && csv::parse_stamp(first_start_, date_and_time, start))
    recording.meta[clock_start] = iso_time(start.time);
  if (cut_line_ == last_line_ && cut_line_ > 0)
    recording.findings.push_back({Finding::Severity::warning, "last_row_incomplete", {{"line", cut_line_}}, path_});
  if (shifted_)
    recording.findings.push_back({Finding::Severity::info, "segments_by_date", {{"segments", segments_}}, path_});
  recording.recognised = {{"decimal mark", mark_ == ',' ? "comma" : "point"},
                          {"separator", separator_ == ',' ? "comma" : "tab"},
                          {"segments", std::to_string(segments_)}};
}

file::Gathered gather(const std::string& path, const ReadOptions& options, std::shared_ptr<file::Spool> spool,
                      const Progress& progress) {
  if (!recognises(path))
    throw Error{Error::Kind::bad_file, say("'{}' does not begin as a LabVIEW measurement file", path)};
  Reader reader(path, options, std::move(spool));
  file::each_line(path, options.encoding, progress,
                  [&](std::string_view line, std::size_t number) { reader.take(line, number); });
  return reader.finish();
}

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  auto checksum = sha256_in_background(path);
  Recording recording = file::in_memory(gather(path, options, nullptr, progress));
  recording.origin.checksum = std::move(checksum);
  return recording;
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  file::hand_out(gather(path, options, std::make_shared<file::Spool>(path), progress), samples, sink, progress);
}

}  // namespace

extern const Format lvm{.name = "lvm",
                        .summary = "LabVIEW measurement file, as text",
                        .extensions = {".lvm"},
                        .recognises = recognises,
                        .read = tumble::lvm::read,
                        .stream = tumble::lvm::stream};

}  // namespace tumble::lvm
