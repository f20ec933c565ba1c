// Universal File Format, dataset 58: functions at nodal degrees of freedom (Structural Dynamics Research Laboratory,
// University of Cincinnati, "Universal File Datasets Summary"). Time responses are read; dataset 164 gives the units.

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/names.hpp"
#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/file/gathered.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/kinds_of_text.hpp"
#include "tumble/formats/file/text_lines.hpp"
#include "tumble/formats/file/unique_names.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/uff58/dataset.hpp"
#include "tumble/units/error.hpp"

namespace tumble::uff58 {

namespace {

bool recognises(const std::string& path) {
  char bytes[1024];
  return file::is_universal({bytes, file::InputFile(path).read(bytes, sizeof bytes)});
}

/// The units of a file by dataset 164.
struct Units {
  long code = 0;  ///< 1: SI
};

class Reader {
 public:
  /// `spool`: where the samples go; null: into memory.
  Reader(const std::string& path, const ReadOptions& options, std::shared_ptr<file::Spool> spool)
      : path_(path), options_(options), spool_(std::move(spool)) {}
  void take(std::string_view line, std::size_t number);
  std::size_t bytes_due() { return std::exchange(bytes_due_, 0); }
  void take_bytes(std::string_view bytes);
  file::Gathered finish();

 private:
  void begin(std::string_view number, std::size_t line);
  void take_58(std::string_view line, std::size_t number);
  void take_binary_head(std::string_view text, std::size_t line);
  void expect_bytes(std::size_t line);
  void take_head(std::size_t number);
  void finish_dataset(std::size_t number);
  void add_channel();
  std::optional<Unit> unit_of(const std::string& name);
  std::string name_of();
  std::string unit_of_type(long type) const;
  void take_number(double number);
  std::optional<Timeline> even_timeline() const;
  void find_time_unit();
  [[noreturn]] void refuse(std::size_t line, const Sentence& reason) const {
    throw Error{Error::Kind::bad_file, say("'{}', line {}: {}", path_, line, reason)};
  }

  std::string path_;
  const ReadOptions& options_;
  std::size_t bytes_due_ = 0;
  enum class Part { between, number, dataset_58, dataset_164, other } part_ = Part::between;
  Dataset dataset_;
  Units units_;
  std::size_t line_of_164_ = 0;
  file::UniqueNames names_;
  std::set<long> other_datasets_;
  std::size_t other_functions_ = 0, read_ = 0;
  Problems problems_;
  std::vector<std::string> without_unit_;
  file::Gathered gathered_;
  std::shared_ptr<file::Spool> spool_;
  std::vector<double> of_line_;
};

void Reader::take(std::string_view line, std::size_t number) {
  if (csv::trimmed(line) == "-1") {
    if (part_ == Part::between) {
      part_ = Part::number;
    } else {
      if (part_ == Part::dataset_58) finish_dataset(number);
      part_ = Part::between;
    }
  } else if (part_ == Part::number) {
    begin(csv::trimmed(line), number);
  } else if (part_ == Part::dataset_58) {
    take_58(line, number);
  } else if (part_ == Part::dataset_164 && line_of_164_++ == 0) {
    units_.code = whole_number(field(line, 0, 10), 0);
  }
}

void Reader::begin(std::string_view number, std::size_t line) {
  const std::string word(number.substr(0, number.find(' ')));
  const bool binary = word == "58b" || word == "58B";
  const long dataset = binary ? 58 : whole_number(word, -1);
  part_ = dataset == 58 ? Part::dataset_58 : dataset == 164 ? Part::dataset_164 : Part::other;
  line_of_164_ = 0;
  if (dataset == 58) {
    dataset_ = {};
    dataset_.line = line + 1;
    dataset_.abscissa = std::make_shared<file::Series>(spool_);
    dataset_.values = std::make_shared<file::Series>(spool_);
    if (binary) take_binary_head(number, line);
  } else if (dataset != 164) {
    other_datasets_.insert(dataset);
  }
}

void Reader::take_binary_head(std::string_view text, std::size_t line) try {
  dataset_.binary = binary_head(text);
} catch (const Error& error) {
  refuse(line, reason_of(error));
}

/// The samples of a binary dataset; those of a complex one are passed over.
void Reader::take_bytes(std::string_view bytes) {
  if (!dataset_.real()) return;
  decode_binary(bytes, dataset_.binary_numbers, dataset_.binary->reversed, of_line_);
  for (const double number : of_line_) take_number(number);
}

/// Behind the eleven lines of a binary dataset.
void Reader::expect_bytes(std::size_t line) {
  Dataset& set = dataset_;
  bytes_due_ = set.binary->bytes;
  set.binary_numbers = binary_numbers(*set.binary, set.ordinate == 4, set.even, static_cast<std::size_t>(set.count));
  if (set.real() && set.binary_numbers.size == 0)
    refuse(line - 11, say("a binary dataset of {} bytes, which {} samples do not take", set.binary->bytes, set.count));
}

void Reader::take_58(std::string_view line, std::size_t number) {
  if (dataset_.records.size() < head_records) {
    dataset_.records.emplace_back(line);
    if (dataset_.records.size() < head_records) return;
    take_head(number);
    if (dataset_.binary) expect_bytes(number);
    return;
  }
  if (!dataset_.real()) return;
  if (!numbers_in(line, of_line_)) refuse(number, say("'{}' does not consist of numbers", csv::plain_text(line, 40)));
  if (dataset_.numbers + of_line_.size() > dataset_.needed())
    refuse(number, say("more numbers than the {} samples of the dataset", dataset_.count));
  for (const double value : of_line_) take_number(value);
}

/// Where the abscissa is not even, each sample has its own before it.
void Reader::take_number(double number) {
  Dataset& set = dataset_;
  const bool is_value = set.even || set.numbers % 2 == 1;
  ++set.numbers;
  (is_value ? set.values : set.abscissa)->add(number);
  if (is_value) return;
  const double stamp = set.time.to_si(number);
  set.clock.add(stamp, 1e-6 * std::abs(stamp));
}

/// Records 6 and 7: what function it is, and how it is written.
void Reader::take_head(std::size_t number) {
  Dataset& set = dataset_;
  const std::string_view function = set.records[5], form = set.records[6];
  set.kind = whole_number(field(function, 0, 5), -1);
  set.ordinate = whole_number(field(form, 0, 10), -1);
  set.count = whole_number(field(form, 10, 10), -1);
  set.even = whole_number(field(form, 20, 10), 1) != 0;
  if (set.ordinate != 2 && set.ordinate != 4 && set.ordinate != 5 && set.ordinate != 6)
    refuse(number - 4, "record 7 of dataset 58: the kind of the ordinate must be 2, 4, 5 or 6");
  if (set.count < 0) refuse(number - 4, "record 7 of dataset 58 has no number of samples");
  std::vector<double> numbers;
  const bool good = form.size() > 30 && numbers_in(form.substr(30), numbers) && numbers.size() >= 2;
  if (set.even && (!good || !(numbers[1] > 0.0) || !(numbers[1] < file::longest_step)))
    refuse(number - 4, "record 7 of dataset 58 has no spacing of the abscissa");
  if (good) {
    set.start = numbers[0];
    set.step = numbers[1];
  }
  find_time_unit();
}

/// Record 8: what the abscissa is in.
void Reader::find_time_unit() {
  const std::string label(field(dataset_.records[7], 47, 20));
  if (label.empty() || label == "NONE") return;
  try {
    const Unit unit = csv::parse_written_unit(label);
    if (kind_of(unit) == QuantityKind::time)
      dataset_.time = unit;
    else
      dataset_.time_problem = ": its abscissa is not a time";
  } catch (const Error& error) {
    dataset_.time_problem = say(", time: {}", reason_of(error));
  }
}

void Reader::finish_dataset(std::size_t number) {
  if (dataset_.records.size() < head_records) refuse(number, "dataset 58 has fewer than 11 records before its samples");
  const long abscissa = whole_number(field(dataset_.records[7], 0, 10), 0);
  const bool time = dataset_.kind == 1 || (dataset_.kind == 0 && abscissa == 17);
  if (!time || !dataset_.real()) {
    ++other_functions_;
    return;
  }
  if (dataset_.numbers != dataset_.needed())
    refuse(number,
           say("{} numbers instead of {} in dataset 58; the file was cut off", dataset_.numbers, dataset_.needed()));
  if (dataset_.count > 0) add_channel();
}

/// The first identification line; else node and direction.
std::string Reader::name_of() {
  constexpr std::string_view directions[] = {"", "X", "Y", "Z", "RX", "RY", "RZ"};
  const std::string_view function = dataset_.records[5];
  std::string name(csv::trimmed(dataset_.records[0]));
  if (name.empty() || name == "NONE") {
    const long direction = whole_number(field(function, 51, 4), 0);
    const auto axis = static_cast<std::size_t>(std::min(std::labs(direction), 6L));
    name = "node" + std::to_string(whole_number(field(function, 41, 10), 0));
    if (axis > 0) name += "." + std::string(direction < 0 ? "-" : "") + std::string(directions[axis]);
  }
  return names_.take(name);
}

std::string Reader::unit_of_type(long type) const {
  if (units_.code != 1) return "";
  switch (type) {
    case 8:
      return "m";
    case 11:
      return "m/s";
    case 12:
      return "m/s^2";
    case 13:
      return "N";
    case 15:
      return "Pa";
    default:
      return "";
  }
}

std::optional<Unit> Reader::unit_of(const std::string& name) {
  const std::string_view ordinate = dataset_.records[8];
  std::string label(field(ordinate, 47, 20));
  if (label == "NONE" || label == "none") label.clear();
  if (label.empty()) label = unit_of_type(whole_number(field(ordinate, 0, 10), 0));
  const auto given = options_.units.find(name);
  try {
    if (!label.empty()) return csv::parse_written_unit(label);
  } catch (const Error& error) {
    if (given == options_.units.end())
      problems_.push_back(say("channel '{}': {}", csv::plain_text(name, 60), reason_of(error)));
  }
  if (given != options_.units.end()) return given->second;
  without_unit_.push_back(name);
  return std::nullopt;
}

/// By start and step, which have six digits, else by the stamps; nothing where these are not even.
std::optional<Timeline> Reader::even_timeline() const {
  const Unit& time = dataset_.time;
  if (dataset_.even) {
    const double step = time.to_si(dataset_.step),
                 half_digit = 0.5 * std::pow(10.0, std::floor(std::log10(step)) - 5.0);
    return Timeline{time.to_si(dataset_.start), file::plainest_rate(step - half_digit, step + half_digit), nullptr};
  }
  return dataset_.clock.timeline(options_.rate);
}

void Reader::add_channel() {
  ++read_;
  const std::string name = name_of();
  if (!options_.only.empty() && std::ranges::find(options_.only, name) == options_.only.end()) return;
  if (!dataset_.time_problem.empty())
    problems_.push_back(say("channel '{}'{}", csv::plain_text(name, 60), dataset_.time_problem));
  const auto unit = unit_of(name);
  if (!unit) return;
  const auto even = even_timeline();
  gathered_.frame.channels.push_back({name, kind_of(*unit), *unit, even.value_or(Timeline{}), {}});
  gathered_.sources.push_back(
      {dataset_.values, even ? nullptr : dataset_.abscissa, dataset_.time.factor(), dataset_.time.offset()});
}

file::Gathered Reader::finish() {
  if (part_ != Part::between)
    throw Error{Error::Kind::bad_file, say("'{}': its last dataset has no end (-1); the file was cut off", path_)};
  if (!without_unit_.empty()) {
    std::string names, sets;
    for (const auto& name : without_unit_) {
      names += (names.empty() ? "'" : ", '") + csv::plain_text(name, 60) + "'";
      sets += " --set 'unit." + csv::plain_text(name, 60) + "=" + csv::likely_unit(name, 0.0) + "'";
    }
    problems_.push_back(say("'{}': channels without a unit: {}", path_, Name{names}));
    problems_.push_back(
        say("to copy, with units to be checked: {}", Name{"tumble inspect " + csv::shell_word(path_) + sets}));
  }
  if (!problems_.empty()) throw Error{Error::Kind::bad_file, problems_};
  Recording& recording = gathered_.frame;
  if (recording.channels.empty())
    throw Error{
        Error::Kind::bad_file,
        say("'{}' has no time response (dataset 58, function type 1) to read{}", path_,
            other_functions_ > 0 ? say("; it has {} spectra or other functions", other_functions_) : Sentence())};
  if (other_functions_ > 0)
    recording.findings.push_back(
        {Finding::Severity::info, "functions_not_read", {{"functions", other_functions_}}, path_});
  std::size_t infinite = 0;  // in binary numbers
  for (const file::Source& source : gathered_.sources) infinite += source.values->infinite();
  if (infinite > 0)
    recording.findings.push_back(
        {Finding::Severity::warning, "infinite_samples", {{"topic", path_}}, "", {infinite, {}, {}}});
  recording.origin.file = path_;
  recording.recognised = {
      {"datasets 58", std::to_string(read_) + " time responses"},
      {"units", units_.code == 1 ? "SI, by dataset 164, where a channel has no label" : "as the channels say"}};
  return std::move(gathered_);
}

file::Gathered gather(const std::string& path, const ReadOptions& options, std::shared_ptr<file::Spool> spool,
                      const Progress& progress) {
  if (!recognises(path))
    throw Error{Error::Kind::bad_file,
                say("'{}' does not begin as a universal file (-1, then the number of a dataset)", path)};
  Reader reader(path, options, std::move(spool));
  if (!has_binary_datasets(path)) {
    file::each_line(path, options.encoding, progress,
                    [&](std::string_view line, std::size_t number) { reader.take(line, number); });
    return reader.finish();
  }
  each_part(path, progress,
            {[&](std::string_view line, std::size_t number) { reader.take(line, number); },
             [&] { return reader.bytes_due(); }, [&](std::string_view bytes) { reader.take_bytes(bytes); }});
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

extern const Format uff58{.name = "uff58",
                          .summary = "universal file, time responses of dataset 58, as text or binary",
                          .extensions = {".uff", ".unv"},
                          .recognises = recognises,
                          .read = tumble::uff58::read,
                          .stream = tumble::uff58::stream};

}  // namespace tumble::uff58
