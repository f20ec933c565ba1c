#include "tumble/formats/recorded_findings.hpp"

#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const FindingValue& value) {
  Json json{{"name", value.name}};
  if (const auto* number = std::get_if<double>(&value.value)) {
    json["value"] = *number;
    json["unit"] = value.unit.text();
  } else if (const auto* count = std::get_if<long long>(&value.value)) {
    json["count"] = *count;
  } else if (const auto* text = std::get_if<std::string>(&value.value)) {
    json["text"] = *text;
  } else {
    const Phrase& phrase = std::get<Phrase>(value.value);
    json["phrase"] = phrase.key;
    json["english"] = phrase.english;
  }
  return json;
}

FindingValue value_of(const Json& json) {
  const std::string name = json.at("name");
  if (json.contains("unit")) {
    const Json& value = json.at("value");
    return {name, value.is_number() ? value.get<double>() : std::nan(""), json.at("unit").get<std::string>()};
  }
  if (json.contains("count")) return {name, json.at("count").get<long long>()};
  if (json.contains("text")) return {name, json.at("text").get<std::string>()};
  return {name, Phrase{json.at("phrase").get<std::string>(), json.value("english", "")}};
}

Json json_of(const Place& place) {
  Json json{{"label", place.label}};
  if (std::isfinite(place.time)) json["time"] = place.time;
  return json;
}

Place place_of(const Json& json) { return Place(json.value("label", ""), json.value("time", std::nan(""))); }

Json json_of(const Finding& finding) {
  Json values = Json::array();
  for (const FindingValue& value : finding.values) values.push_back(json_of(value));
  return {{"severity", static_cast<int>(finding.severity)},
          {"code", finding.code},
          {"message", finding.message},
          {"where", finding.where},
          {"values", values},
          {"count", finding.occurrences.count},
          {"first", json_of(finding.occurrences.first)},
          {"worst", json_of(finding.occurrences.worst)}};
}

Finding finding_of(const Json& json) {
  Finding finding;
  const int severity = json.at("severity");
  if (severity < 0 || severity > static_cast<int>(Finding::Severity::error))
    throw Error(Error::Kind::bad_file, "a finding has an unknown severity");
  finding.severity = static_cast<Finding::Severity>(severity);
  finding.code = json.at("code");
  finding.message = json.at("message");
  finding.where = json.at("where");
  for (const Json& value : json.at("values")) finding.values.push_back(value_of(value));
  finding.occurrences = {json.at("count"), place_of(json.at("first")), place_of(json.at("worst"))};
  return finding;
}

}  // namespace

std::string text_of_findings(const Findings& findings) {
  Json all = Json::array();
  for (const Finding& finding : findings) all.push_back(json_of(finding));
  return json_text(all);
}

Findings recorded_findings(const std::map<std::string, std::string>& meta) {
  const auto text = meta.find(std::string(recorded_findings_key));
  if (text == meta.end()) return {};
  try {
    Findings findings;
    for (const Json& one : Json::parse(text->second)) findings.push_back(finding_of(one));
    return findings;
  } catch (const Json::exception&) {
  } catch (const Error&) {
  }
  return {};
}

}  // namespace tumble
