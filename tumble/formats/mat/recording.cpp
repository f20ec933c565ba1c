#include "tumble/formats/mat/recording.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/topics/choose.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mat {
namespace {

constexpr std::size_t longest_note = 200;  ///< [characters] of a text in the meta data

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// "imu" of "imu.gyro"; empty for a variable of its own.
std::string parent_of(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == name.npos ? "" : name.substr(0, dot);
}

std::string last_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

/// The unit of time that the name of a variable implies; nothing where it is no time.
std::optional<std::string> time_unit(const std::string& name) {
  std::string word = lower(last_of(name));
  std::string unit = "s";
  for (const char* suffix : {"_s", "_ms", "_us", "_ns"})
    if (word.ends_with(suffix) && word.size() > std::string(suffix).size()) {
      unit = suffix + 1;
      word.resize(word.size() - std::string(suffix).size());
      break;
    }
  for (const char* known : {"t", "time", "timestamp", "timestamps", "stamps", "tout"})
    if (word == known) return unit;
  return std::nullopt;
}

/// [Hz] that a number of this name means; nothing for any other name.
std::optional<double> rate_of(const std::string& name, double value) {
  const std::string word = lower(last_of(name));
  if (!(value > 0.0) || !std::isfinite(value)) return std::nullopt;
  for (const char* known : {"fs", "f_s", "rate", "sample_rate", "samplerate", "sampling_rate", "frequency", "freq"})
    if (word == known) return value;
  for (const char* known : {"dt", "ts", "t_s", "sample_time", "sampletime", "sampling_interval"})
    if (word == known) return 1.0 / value;
  return std::nullopt;
}

/// Whether the numbers read as days since the year 0, of the years 1950 to 2100: then they are far too dense for
/// seconds.
bool are_days(const std::vector<double>& times) {
  constexpr double earliest = 712'224.0, latest = 767'376.0, densest = 1e-4;  // days; s between two samples
  if (times.size() < 2) return false;
  const double interval = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  return times.front() > earliest && times.back() < latest && interval > 0.0 && interval < densest;
}

/// Makes infinite values NaN; their number.
std::size_t remove_infinite(std::vector<double>& values) {
  std::size_t count = 0;
  for (double& value : values) {
    if (!std::isinf(value)) continue;
    ++count;
    value = std::numeric_limits<double>::quiet_NaN();
  }
  return count;
}

/// A channel before its unit is known.
struct Vector {
  std::string name;
  std::string variable;
  std::size_t array = 0, index = 0;
  std::optional<Unit> unit;
};

class Maker {
 public:
  Maker(Contents contents, const std::string& path, const ReadOptions& options)
      : contents_(std::move(contents)), path_(path), options_(options) {}

  Recording make() {
    recording_.origin.file = path_;
    choose();
    for (const std::size_t i : chosen_) clocks_.push_back(clock_of(i));
    name_vectors();
    find_units();
    finish();
    take_meta();
    return std::move(recording_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Error::Kind::bad_file, "'" + path_ + "' " + what);
  }

  bool is_time(std::size_t i) const {
    const Array& array = contents_.arrays[i];
    return array.vectors.size() == 1 && array.length() > 1 && time_unit(array.name);
  }

  /// The time of an array among what stands in `at`, its structure or one around it.
  std::optional<std::size_t> time_in(const std::string& at, std::size_t i) const {
    for (std::size_t k = 0; k < contents_.arrays.size(); ++k)
      if (is_time(k) && k != i && parent_of(contents_.arrays[k].name) == at &&
          contents_.arrays[k].length() == contents_.arrays[i].length())
        return k;
    return std::nullopt;
  }

  bool has_time(std::size_t i) const {
    for (std::string at = parent_of(contents_.arrays[i].name);; at = parent_of(at)) {
      if (time_in(at, i)) return true;
      if (at.empty()) return false;
    }
  }

  std::optional<double> rate_in(const std::string& at) const {
    for (const Array& other : contents_.arrays)
      if (other.length() == 1 && other.vectors.size() == 1 && parent_of(other.name) == at)
        if (const auto rate = rate_of(other.name, other.vectors[0][0])) return rate;
    return std::nullopt;
  }

  std::optional<double> rate_for(const Array& array) const {
    if (options_.rate) return options_.rate;
    for (std::string at = parent_of(array.name);; at = parent_of(at)) {
      if (const auto rate = rate_in(at)) return rate;
      if (at.empty()) return std::nullopt;
    }
  }

  /// Those asked for; without that, those with a time and the longest.
  void choose() {
    std::vector<std::size_t> candidates;
    std::vector<std::string> names;
    std::size_t longest = 0;
    for (std::size_t i = 0; i < contents_.arrays.size(); ++i) {
      const Array& array = contents_.arrays[i];
      if (array.length() < 2 || is_time(i)) continue;
      candidates.push_back(i);
      names.push_back(array.name);
      longest = std::max(longest, array.length());
    }
    if (candidates.empty())
      refuse(contents_.cut_off ? "is cut off before its first samples"
                               : "holds no array of numbers with more than one sample" + skipped());
    std::vector<std::size_t> picked;
    if (options_.topics.empty()) {
      for (std::size_t k = 0; k < candidates.size(); ++k)
        if (contents_.arrays[candidates[k]].length() == longest || has_time(candidates[k])) picked.push_back(k);
    } else {
      picked = asked_for(names);
    }
    for (const std::size_t k : picked) chosen_.push_back(candidates[k]);
    topics::name_the_others(names, picked, recording_.findings);
  }

  /// "imu" means every array in this structure.
  std::vector<std::size_t> asked_for(const std::vector<std::string>& names) const {
    std::vector<std::string> wanted;
    for (const std::string& asked : options_.topics) {
      bool met = false;
      for (const std::string& name : names)
        if (name.starts_with(asked + ".")) {
          wanted.push_back(name);
          met = true;
        }
      if (!met) wanted.push_back(asked);
    }
    return topics::asked_for(names, wanted, path_);
  }

  std::string skipped() const {
    if (contents_.skipped.empty()) return "";
    return fmt::format("; not read are {} (complex, sparse, a table, an object, or more than two dimensions)",
                       fmt::join(contents_.skipped, ", "));
  }

  /// The nearest: beside the array, else in the structures around it; there a time before a rate.
  std::optional<Timeline> clock_of(std::size_t i) {
    const Array& array = contents_.arrays[i];
    if (!options_.columns.empty()) return column_clock(array);
    for (std::string at = parent_of(array.name);; at = parent_of(at)) {
      if (const auto time = time_in(at, i)) {
        const Array& stamps = contents_.arrays[*time];
        const auto given = options_.units.find(stamps.name);
        const Unit unit = given == options_.units.end() ? Unit::parse(*time_unit(stamps.name)) : given->second;
        return timeline_of(stamps.name, stamps.vectors.front(), unit);
      }
      if (!options_.rate)
        if (const auto rate = rate_in(at)) return Timeline{0.0, *rate, nullptr};
      if (at.empty()) break;
    }
    return options_.rate ? std::optional(Timeline{0.0, *options_.rate, nullptr}) : std::nullopt;
  }

  /// Arrays with one time share its stamps.
  Timeline timeline_of(const std::string& name, const std::vector<double>& written, const Unit& unit) {
    if (const auto known = timelines_.find(name); known != timelines_.end()) return known->second;
    if (kind_of(unit) != QuantityKind::time)
      refuse(fmt::format("has the time {} in {}, which is no unit of time", name, unit.text()));
    if (options_.units.find(name) == options_.units.end() && options_.columns.empty() && are_days(written))
      refuse(
          fmt::format("has {0} in days, as datenum of MATLAB gives it; say so: --set unit.{0}=day (or "
                      "--set unit.{0}=s if they are seconds)",
                      name));
    file::EvenClock clock;
    auto stamps = std::make_shared<std::vector<double>>();
    stamps->reserve(written.size());
    for (const double value : written) {
      if (!std::isfinite(value)) refuse(fmt::format("has no time at sample {} of {}", stamps->size() + 1, name));
      stamps->push_back(unit.to_si(value));
      clock.add(stamps->back(), 0.0);
    }
    const auto even = clock.timeline();
    return timelines_[name] = even ? *even : Timeline{0.0, 0.0, std::move(stamps)};
  }

  /// The column that `columns` call time.
  std::optional<Timeline> column_clock(const Array& array) {
    for (std::size_t k = 0; k < std::min(options_.columns.size(), array.vectors.size()); ++k) {
      const auto [name, unit] = name_and_unit_of(options_.columns[k]);
      if (time_unit(name)) return timeline_of(name, array.vectors[k], unit ? *unit : Unit::parse(*time_unit(name)));
    }
    const auto rate = rate_for(array);
    return rate ? std::optional(Timeline{0.0, *rate, nullptr}) : std::nullopt;
  }

  static std::pair<std::string, std::optional<Unit>> name_and_unit_of(const std::string& text) {
    const auto open = text.rfind('[');
    if (open == text.npos || !text.ends_with(']')) return {text, std::nullopt};
    return {text.substr(0, open), Unit::parse(text.substr(open + 1, text.size() - open - 2))};
  }

  void name_vectors() {
    if (!options_.columns.empty()) return name_columns();
    for (const std::size_t i : chosen_) {
      const Array& array = contents_.arrays[i];
      const std::size_t count = array.vectors.size();
      for (std::size_t k = 0; k < count; ++k) {
        std::string name = array.name;
        if (count == 3) name += std::string(".") + "xyz"[k];
        if (count > 1 && count != 3) name += "." + std::to_string(k + 1);
        while (std::ranges::find(vectors_, name, &Vector::name) != vectors_.end()) name += "_";  // the file has two
        vectors_.push_back({name, array.name, i, k, std::nullopt});
      }
    }
  }

  void name_columns() {
    if (chosen_.size() != 1)
      refuse(fmt::format("holds {} arrays, and columns name those of one: name it with --topic", chosen_.size()));
    const Array& array = contents_.arrays[chosen_.front()];
    if (array.vectors.size() != options_.columns.size())
      refuse(fmt::format("has {} columns in {}, and {} were named", array.vectors.size(), array.name,
                         options_.columns.size()));
    for (std::size_t k = 0; k < array.vectors.size(); ++k) {
      const auto [name, unit] = name_and_unit_of(options_.columns[k]);
      if (name != "-" && !time_unit(name)) vectors_.push_back({name, array.name, chosen_.front(), k, unit});
    }
  }

  bool wanted(const std::string& name) const {
    return options_.only.empty() || std::ranges::find(options_.only, name) != options_.only.end();
  }

  /// By channel, else by variable.
  std::optional<Unit> unit_of(const Vector& vector) const {
    if (vector.unit) return vector.unit;
    for (const std::string& name : {vector.name, vector.variable})
      if (const auto given = options_.units.find(name); given != options_.units.end()) return given->second;
    return std::nullopt;
  }

  void find_units() {
    std::erase_if(vectors_, [&](const Vector& vector) { return !wanted(vector.name); });
    if (vectors_.empty()) refuse("has no channel of that name to read");
    std::vector<std::string> without_unit, without_time, problems;
    for (Vector& vector : vectors_) {
      vector.unit = unit_of(vector);
      if (!vector.unit) without_unit.push_back(vector.name);
      if (!clocks_[position_of(vector.array)] && std::ranges::find(without_time, vector.variable) == without_time.end())
        without_time.push_back(vector.variable);
    }
    if (!without_unit.empty())
      problems.push_back(
          fmt::format("'{}': these have no unit: {}; give it for a channel or a whole variable: --set unit.{}=deg/s, "
                      "or in the plan's "
                      "[channels] table: role = \"{}[deg/s]\"{}",
                      path_, fmt::join(without_unit, ", "), vectors_.front().variable, without_unit.front(),
                      recording_.findings.empty() ? "" : "; --topic NAME reads only what is named"));
    if (!without_time.empty())
      problems.push_back(
          fmt::format("'{}': these have no time: {}; give the sampling rate (--set rate=100), or save a vector t of "
                      "the same length, "
                      "or a number fs [Hz], beside them",
                      path_, fmt::join(without_time, ", ")));
    if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
  }

  std::size_t position_of(std::size_t array) const {
    return static_cast<std::size_t>(std::ranges::find(chosen_, array) - chosen_.begin());
  }

  void finish() {
    std::size_t infinite = 0;
    for (Vector& vector : vectors_) {
      Channel channel{vector.name, kind_of(*vector.unit), *vector.unit, *clocks_[position_of(vector.array)],
                      std::move(contents_.arrays[vector.array].vectors[vector.index])};
      if (contents_.arrays[vector.array].infinite) infinite += remove_infinite(channel.values);
      const double factor = channel.unit.factor(), offset = channel.unit.offset();
      if (factor != 1.0 || offset != 0.0)
        for (double& value : channel.values) value = value * factor + offset;
      recording_.channels.push_back(std::move(channel));
    }
    if (infinite > 0)
      recording_.findings.push_back(
          {Finding::Severity::warning, "infinite_samples", {{"topic", path_}}, "", {infinite, {}, {}}});
    if (contents_.cut_off) recording_.findings.push_back({Finding::Severity::warning, "mat_cut_off", {}});
    if (!contents_.skipped.empty())
      recording_.findings.push_back({Finding::Severity::info,
                                     "variables_not_read",
                                     {{"variables", fmt::format("{}", fmt::join(contents_.skipped, ", "))}}});
  }

  void take_meta() {
    std::string head = contents_.head.substr(0, contents_.head.find('\0'));
    while (head.ends_with(' ')) head.pop_back();
    std::ranges::replace_if(
        head, [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
    if (!head.empty()) recording_.meta["file"] = head;
    for (const auto& [name, text] : contents_.texts)
      if (text.size() <= longest_note) recording_.meta[name] = text;
  }

  Contents contents_;
  const std::string& path_;
  const ReadOptions& options_;
  Recording recording_;
  std::vector<std::size_t> chosen_;              ///< arrays
  std::vector<std::optional<Timeline>> clocks_;  ///< of the chosen arrays
  std::map<std::string, Timeline> timelines_;
  std::vector<Vector> vectors_;
};

}  // namespace

Recording recording_of(Contents contents, const std::string& path, const ReadOptions& options) {
  return Maker(std::move(contents), path, options).make();
}

}  // namespace tumble::mat
