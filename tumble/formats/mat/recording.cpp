#include "tumble/formats/mat/recording.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "tumble/formats/file/even_clock.hpp"
#include "tumble/formats/file/unique_names.hpp"
#include "tumble/formats/mat/times.hpp"
#include "tumble/formats/topics/choose.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mat {
namespace {

constexpr std::size_t longest_note = 200;  ///< [characters] of a text in the meta data
constexpr std::size_t stamps_at_once = 65536;

/// Whether the numbers read as days since the year 0, of the years 1950 to 2100: then they are far too dense for
/// seconds.
bool are_days(const file::Series& times) {
  constexpr double earliest = 712'224.0, latest = 767'376.0, densest = 1e-4;  // days; s between two samples
  if (times.size() < 2) return false;
  const double first = times.at(0), last = times.at(times.size() - 1);
  const double interval = (last - first) / static_cast<double>(times.size() - 1);
  return first > earliest && last < latest && interval > 0.0 && interval < densest;
}

/// Whether the numbers, taken for seconds, are later than the year 2103: they count ms, us or ns.
bool are_finer(const file::Series& times) {
  constexpr double latest = 4.2e9;  // s since 1970
  return times.size() > 0 && times.at(0) > latest;
}

/// The times of an array: even, or the stamps as written.
struct Clock {
  std::optional<Timeline> even;
  std::shared_ptr<const file::Series> stamps;
  Unit unit;  ///< of the stamps
};

Clock even_clock(double rate) { return {Timeline{0.0, rate, nullptr}, nullptr, {}}; }

/// A channel before its unit is known.
struct Vector {
  std::string name;
  std::string variable;
  std::size_t chosen = 0, index = 0;  ///< of the array among those chosen, and in it
  std::optional<Unit> unit;
};

class Maker {
 public:
  Maker(Contents contents, const std::string& path, const ReadOptions& options)
      : contents_(std::move(contents)), times_(contents_.arrays), path_(path), options_(options) {}

  file::Gathered make() {
    recording_.origin.file = path_;
    choose();
    for (const std::size_t i : chosen_) clocks_.push_back(clock_of(i));
    name_vectors();
    find_units();
    finish();
    take_meta();
    return {std::move(recording_), std::move(sources_)};
  }

 private:
  [[noreturn]] void refuse(const Sentence& what) const {
    throw Error(Error::Kind::bad_file, say("'{}' {}", path_, what));
  }

  bool has_time(std::size_t i) const {
    for (std::string at = parent_of(contents_.arrays[i].name);; at = parent_of(at)) {
      if (times_.time_in(at, i)) return true;
      if (at.empty()) return false;
    }
  }

  std::optional<double> rate_for(const Array& array) const {
    if (options_.rate) return options_.rate;
    for (std::string at = parent_of(array.name);; at = parent_of(at)) {
      if (const auto rate = times_.rate_in(at)) return rate;
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
      if (array.length() < 2 || times_.is_time(i)) continue;
      candidates.push_back(i);
      names.push_back(array.name);
      longest = std::max(longest, array.length());
    }
    if (candidates.empty())
      refuse(contents_.cut_off ? Sentence("is cut off before its first samples")
                               : say("holds no array of numbers with more than one sample{}", skipped()));
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

  /// With dots where there are more than are named.
  std::vector<std::string> not_read() const {
    auto names = contents_.skipped;
    if (contents_.skipped_too > 0) names.emplace_back("...");
    return names;
  }

  Sentence skipped() const {
    if (contents_.skipped.empty()) return {};
    return say("; not read are {} (complex, sparse, a table, an object, or more than two dimensions)",
               fmt::join(not_read(), ", "));
  }

  /// The nearest: beside the array, else in the structures around it; there a time before a rate.
  std::optional<Clock> clock_of(std::size_t i) {
    const Array& array = contents_.arrays[i];
    if (!options_.columns.empty()) return column_clock(array);
    for (std::string at = parent_of(array.name);; at = parent_of(at)) {
      if (const auto time = times_.time_in(at, i)) {
        const Array& stamps = contents_.arrays[*time];
        const auto given = options_.units.find(stamps.name);
        const Unit unit = given == options_.units.end() ? Unit::parse(*time_unit(stamps.name)) : given->second;
        return times_of(stamps.name, stamps.vectors.front(), unit);
      }
      if (!options_.rate)
        if (const auto rate = times_.rate_in(at)) return even_clock(*rate);
      if (at.empty()) break;
    }
    return options_.rate ? std::optional(even_clock(*options_.rate)) : std::nullopt;
  }

  /// Arrays with one time share its stamps.
  Clock times_of(const std::string& name, const std::shared_ptr<const file::Series>& written, const Unit& unit) {
    if (const auto known = clocks_by_name_.find(name); known != clocks_by_name_.end()) return known->second;
    if (kind_of(unit) != QuantityKind::time)
      refuse(say("has the time {} in {}, which is no unit of time", Name{name}, Name{unit.text()}));
    const bool unit_is_guessed =
        options_.units.find(name) == options_.units.end() && options_.columns.empty() && unit.factor() == 1.0;
    if (unit_is_guessed && are_days(*written))
      refuse(
          say("has {0} in days, as datenum of MATLAB gives it; say so: --set unit.{0}=day (or "
              "--set unit.{0}=s if they are seconds)",
              Name{name}));
    if (unit_is_guessed && are_finer(*written))
      refuse(
          say("has {0} in numbers that are too large for seconds; say their unit: --set unit.{0}=ms (or us, ns; "
              "or --set unit.{0}=s if they are seconds)",
              Name{name}));
    file::EvenClock clock;
    std::vector<double> piece;
    for (std::size_t first = 0; first < written->size(); first += piece.size()) {
      piece.clear();
      written->read(first, std::min(stamps_at_once, written->size() - first), piece);
      for (const double value : piece) {
        if (!std::isfinite(value)) refuse(say("has no time at sample {} of {}", clock.count() + 1, Name{name}));
        clock.add(unit.to_si(value), 0.0);
      }
    }
    const auto even = clock.timeline(options_.rate);
    return clocks_by_name_[name] = {even, even ? nullptr : written, unit};
  }

  /// The column that `columns` call time.
  std::optional<Clock> column_clock(const Array& array) {
    for (std::size_t k = 0; k < std::min(options_.columns.size(), array.vectors.size()); ++k) {
      const auto [name, unit] = name_and_unit_of(options_.columns[k]);
      if (time_unit(name)) return times_of(name, array.vectors[k], unit ? *unit : Unit::parse(*time_unit(name)));
    }
    const auto rate = rate_for(array);
    return rate ? std::optional(even_clock(*rate)) : std::nullopt;
  }

  static std::pair<std::string, std::optional<Unit>> name_and_unit_of(const std::string& text) {
    const auto open = text.rfind('[');
    if (open == text.npos || !text.ends_with(']')) return {text, std::nullopt};
    return {text.substr(0, open), Unit::parse(text.substr(open + 1, text.size() - open - 2))};
  }

  void name_vectors() {
    if (!options_.columns.empty()) return name_columns();
    file::UniqueNames names;  // the file may have two
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const Array& array = contents_.arrays[chosen_[i]];
      const std::size_t count = array.vectors.size();
      for (std::size_t k = 0; k < count; ++k) {
        std::string name = array.name;
        if (count == 3) name += std::string(".") + "xyz"[k];
        if (count > 1 && count != 3) name += "." + std::to_string(k + 1);
        vectors_.push_back({names.take(name), array.name, i, k, std::nullopt});
      }
    }
  }

  void name_columns() {
    if (chosen_.size() != 1)
      refuse(say("holds {} arrays, and columns name those of one: name it with --topic", chosen_.size()));
    const Array& array = contents_.arrays[chosen_.front()];
    if (array.vectors.size() != options_.columns.size())
      refuse(say("has {} columns in {}, and {} were named", array.vectors.size(), Name{array.name},
                 options_.columns.size()));
    for (std::size_t k = 0; k < array.vectors.size(); ++k) {
      const auto [name, unit] = name_and_unit_of(options_.columns[k]);
      if (name != "-" && !time_unit(name)) vectors_.push_back({name, array.name, 0, k, unit});
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
    std::vector<std::string> without_unit, without_time;
    std::set<std::string> told;
    Problems problems;
    for (Vector& vector : vectors_) {
      vector.unit = unit_of(vector);
      if (!vector.unit) without_unit.push_back(vector.name);
      if (!clocks_[vector.chosen] && told.insert(vector.variable).second) without_time.push_back(vector.variable);
    }
    if (!without_unit.empty())
      problems.push_back(
          say("'{}': these have no unit: {}; give it for a channel or a whole variable: --set unit.{}=deg/s, "
              "or in the plan's "
              "[channels] table: role = \"{}[deg/s]\"{}",
              path_, fmt::join(without_unit, ", "), Name{vectors_.front().variable}, Name{without_unit.front()},
              recording_.findings.empty() ? "" : "; --topic NAME reads only what is named"));
    if (!without_time.empty())
      problems.push_back(
          say("'{}': these have no time: {}; give the sampling rate (--set rate=100), or save a vector t of "
              "the same length, "
              "or a number fs [Hz], beside them",
              path_, fmt::join(without_time, ", ")));
    if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
  }

  void finish() {
    std::size_t infinite = 0;
    for (Vector& vector : vectors_) {
      const Clock& clock = *clocks_[vector.chosen];
      const auto& values = contents_.arrays[chosen_[vector.chosen]].vectors[vector.index];
      infinite += values->infinite();
      recording_.channels.push_back(
          {vector.name, kind_of(*vector.unit), *vector.unit, clock.even.value_or(Timeline{}), {}});
      sources_.push_back({values, clock.stamps, clock.unit.factor(), clock.unit.offset()});
    }
    if (infinite > 0)
      recording_.findings.push_back(
          {Finding::Severity::warning, "infinite_samples", {{"topic", path_}}, "", {infinite, {}, {}}});
    if (contents_.cut_off) recording_.findings.push_back({Finding::Severity::warning, "mat_cut_off", {}});
    if (!contents_.skipped.empty())
      recording_.findings.push_back({Finding::Severity::info,
                                     "variables_not_read",
                                     {{"variables", fmt::format("{}", fmt::join(not_read(), ", "))}}});
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
  Times times_;
  const std::string& path_;
  const ReadOptions& options_;
  Recording recording_;
  std::vector<std::size_t> chosen_;  ///< arrays
  std::vector<file::Source> sources_;
  std::vector<std::optional<Clock>> clocks_;  ///< of the chosen arrays
  std::map<std::string, Clock> clocks_by_name_;
  std::vector<Vector> vectors_;
};

}  // namespace

file::Gathered recording_of(Contents contents, const std::string& path, const ReadOptions& options) {
  return Maker(std::move(contents), path, options).make();
}

}  // namespace tumble::mat
