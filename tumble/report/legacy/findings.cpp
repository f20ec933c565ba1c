#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "tumble/report/legacy/legacy.hpp"

namespace tumble::legacy {
namespace {

/// The codes whose value `limit` is that of a parameter without a value.
constexpr std::array<std::string_view, 4> limiting{"not_significant", "noise_term_not_significant",
                                                   "repeatability_not_significant", "noise_term_may_be_another"};

/// The codes of errors that concern all parameters, whatever their place.
constexpr std::array<std::string_view, 13> of_all{"gravity_inverted",
                                                  "gyro_axis_is_another",
                                                  "gyro_counts_down",
                                                  "gyro_gain_far_from_stated",
                                                  "gyro_reversed",
                                                  "rates_inverted",
                                                  "response_inverted",
                                                  "rest_inverted",
                                                  "scale_factor_negative",
                                                  "scale_factor_negative_in_set",
                                                  "scale_factor_of_other_sign",
                                                  "temperature_sensor_stuck",
                                                  "wrong_sign"};

template <std::size_t size>
bool is_one_of(const std::array<std::string_view, size>& codes, const Finding& finding) {
  return std::ranges::find(codes, std::string_view(finding.code)) != codes.end();
}

/// A value that is a text; empty: there is none of that name.
std::string text_of(const Finding& finding, std::string_view name) {
  const auto value = std::ranges::find(finding.values, name, &FindingValue::name);
  const auto* text = value == finding.values.end() ? nullptr : std::get_if<std::string>(&value->value);
  return text ? *text : "";
}

/// Whether the name of a parameter begins with that of a channel: gyro_x.bias, gyro_x_bias.
bool is_of_channel(const std::string& parameter, const std::string& channel) {
  return !channel.empty() && parameter.size() > channel.size() && parameter.starts_with(channel) &&
         (parameter[channel.size()] == '.' || parameter[channel.size()] == '_');
}

}  // namespace

std::vector<HiddenParameter> hidden_by(const Finding& finding) {
  if (!is_one_of(limiting, finding)) return {};
  if (const std::string parameter = text_of(finding, "parameter"); !parameter.empty()) return {{parameter}};
  const std::string term = text_of(finding, "term");
  std::vector<HiddenParameter> hidden;
  for (std::size_t begin = 0; !term.empty() && begin < finding.where.size();) {
    const auto end = std::min(finding.where.find(", ", begin), finding.where.size());
    const std::string channel = finding.where.substr(begin, end - begin);
    hidden.push_back({channel + "." + term, channel});
    begin = end + 2;
  }
  return hidden;
}

std::vector<std::size_t> about_of(const Finding& finding, const std::vector<Parameter>& parameters) {
  std::vector<std::size_t> indices;
  if (is_one_of(of_all, finding)) return indices;
  std::istringstream names(text_of(finding, "parameters"));
  for (std::string name; names >> name;)
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].name == name) indices.push_back(i);
  if (!indices.empty()) return indices;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].name == finding.where || is_of_channel(parameters[i].name, finding.where)) indices.push_back(i);
  return indices;
}

std::optional<std::uintmax_t> memory_of(const Findings& findings) {
  const auto blocks = std::ranges::find(findings, "processed_in_blocks", &Finding::code);
  if (blocks == findings.end()) return std::nullopt;
  const auto memory = std::ranges::find(blocks->values, "memory", &FindingValue::name);
  if (memory == blocks->values.end()) return std::nullopt;
  if (const auto* whole = std::get_if<long long>(&memory->value)) return static_cast<std::uintmax_t>(*whole);
  if (const auto* real = std::get_if<double>(&memory->value)) return static_cast<std::uintmax_t>(*real);
  return std::nullopt;
}

}  // namespace tumble::legacy
