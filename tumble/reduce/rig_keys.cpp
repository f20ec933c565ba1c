#include "tumble/reduce/rig_keys.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>

#include "tumble/rigs/error_names.hpp"

namespace tumble::rig_keys {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Lines with keys that more results have come first; of equals the first in the alphabet.
const std::string& most_frequent(const std::map<std::string, std::size_t>& count) {
  return std::ranges::max_element(count, {}, [](const auto& entry) { return entry.second; })->first;
}

}  // namespace

bool is_error_of_rig(const std::string& source) {
  namespace names = error_names;
  constexpr std::array<std::string_view, 17> whole{
      names::level_about_east,  names::level_about_north,    names::azimuth,         names::radius,
      names::stretch_of_radius, names::table_tilt_about_arm, names::inner_to_outer,  names::table_tilt_across_arm,
      names::middle_to_outer,   names::inner_to_middle,      names::shake_amplitude, names::cross_motion_y,
      names::cross_motion_z,    names::reference_gain,       names::second_harmonic, names::third_harmonic,
      names::thermometer_offset};
  constexpr std::array<std::string_view, 7> begins{
      names::thermometer_scale,       names::index_zero_of, names::wobble_of,
      names::angle_error_of,          names::rate_error_of, names::rate_ripple_of,
      names::oscillation_amplitude_of};
  return std::ranges::find(whole, source) != whole.end() ||
         std::ranges::any_of(begins, [&](std::string_view part) { return source.starts_with(part); });
}

std::string plain(const std::string& key) {
  std::string out;
  for (const char c : key)
    if (const auto byte = static_cast<unsigned char>(c); std::isalnum(byte) || byte > 127)
      out += static_cast<char>(std::tolower(byte));
  return out;
}

bool look_like_a_slip(const std::string& a, const std::string& b) {
  const std::string& longer = a.size() < b.size() ? b : a;
  const std::string& shorter = a.size() < b.size() ? a : b;
  if (a == b || longer.size() - shorter.size() > 1) return false;
  std::size_t same = 0;
  while (same < shorter.size() && shorter[same] == longer[same]) ++same;
  if (longer.size() > shorter.size()) return !is_digit(longer[same]) && longer.substr(same + 1) == shorter.substr(same);
  return longer.substr(same + 1) == shorter.substr(same + 1) && !(is_digit(longer[same]) && is_digit(shorter[same]));
}

Keys::Keys(const std::vector<const Estimate*>& results) {
  std::map<std::pair<std::string, std::string>, std::map<std::string, std::size_t>> written;
  for (const auto* result : results)
    for (const auto& line : result->budget)
      if (!line.key.empty()) ++written[{line.source, plain(line.key)}][line.key];
  std::map<std::string, std::map<std::string, std::size_t>> by_source;
  for (const auto& [key, count] : written) {
    spelling_[key] = most_frequent(count);
    for (const auto& [text, number] : count) by_source[key.first][spelling_[key]] += number;
  }
  for (const auto& [source, count] : by_source) most_[source] = most_frequent(count);
}

std::string Keys::of(const Contribution& line) const {
  if (!line.key.empty()) {
    const auto found = spelling_.find({line.source, plain(line.key)});
    return found == spelling_.end() ? line.key : found->second;
  }
  if (!is_error_of_rig(line.source)) return {};
  const auto most = most_.find(line.source);
  return most == most_.end() ? unstated : most->second;
}

Estimate with_keys_of(Estimate result, const Estimate& population) {
  const Keys keys({&population});
  for (auto& line : result.budget) {
    const bool stated = !line.key.empty();
    line.key = keys.of(line);
    if (!stated || !is_error_of_rig(line.source)) continue;
    const auto of_source = [&](const std::string& key) {
      return std::ranges::any_of(population.budget, [&](const Contribution& other) {
        return other.source == line.source && other.key == key;
      });
    };
    if (!of_source(line.key) && of_source(unstated)) line.key = unstated;
  }
  return result;
}

Findings about_keys(const std::vector<const Estimate*>& results) {
  std::set<std::string> unstated_sources, keys;
  for (const auto* result : results)
    for (const auto& line : result->budget) {
      const bool of_rig = is_error_of_rig(line.source);
      if (of_rig && (line.key.empty() || line.key == unstated)) unstated_sources.insert(line.source);
      if (of_rig && !line.key.empty()) keys.insert(line.key);
    }
  Findings findings;
  if (!unstated_sources.empty()) {
    std::string sources;
    for (const auto& source : unstated_sources) sources += (sources.empty() ? "" : ", ") + source;
    findings.push_back({Finding::Severity::info, "rig_not_stated", {{"errors", sources}}});
  }
  for (auto a = keys.begin(); a != keys.end(); ++a)
    for (auto b = std::next(a); b != keys.end(); ++b) {
      if (plain(*a) == plain(*b))
        findings.push_back({Finding::Severity::warning, "equipment_spelled_twice", {{"one", *a}, {"other", *b}}});
      else if (look_like_a_slip(*a, *b))
        findings.push_back({Finding::Severity::warning, "equipment_alike", {{"one", *a}, {"other", *b}}});
    }
  return findings;
}

}  // namespace tumble::rig_keys
