#include "tumble/formats/mat/times.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace tumble::mat {
namespace {

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string last_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

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

constexpr std::size_t times_kept = 2;  ///< [1] the first one, and another where the array is the first one itself

}  // namespace

std::string parent_of(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == name.npos ? "" : name.substr(0, dot);
}

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

Times::Times(const std::vector<Array>& arrays) : arrays_(arrays) {
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const Array& array = arrays[i];
    if (array.vectors.size() != 1) continue;
    if (is_time(i)) {
      auto& here = times_[{parent_of(array.name), array.length()}];
      if (here.size() < times_kept) here.push_back(i);
    }
    if (array.length() == 1)
      if (const auto rate = rate_of(array.name, array.vectors[0]->at(0))) rates_.emplace(parent_of(array.name), *rate);
  }
}

bool Times::is_time(std::size_t array) const {
  const Array& one = arrays_[array];
  return one.vectors.size() == 1 && one.length() > 1 && time_unit(one.name);
}

std::optional<std::size_t> Times::time_in(const std::string& at, std::size_t array) const {
  const auto found = times_.find({at, arrays_[array].length()});
  if (found == times_.end()) return std::nullopt;
  const auto other = std::ranges::find_if(found->second, [&](std::size_t time) { return time != array; });
  return other == found->second.end() ? std::nullopt : std::optional(*other);
}

std::optional<double> Times::rate_in(const std::string& at) const {
  const auto found = rates_.find(at);
  return found == rates_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace tumble::mat
