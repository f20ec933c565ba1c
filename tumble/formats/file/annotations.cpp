#include "tumble/formats/file/annotations.hpp"

#include <limits>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/formats/recorded_findings.hpp"

namespace tumble::file {

using Json = nlohmann::ordered_json;

namespace {

/// Bytes that are not UTF-8 become the replacement character instead of an exception.

/// Discarded where it is not JSON, or nested so deep that walking it would use up the stack.
Json parsed(std::string_view text) {
  int depth = 0;
  for (const char c : text) {
    depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (depth > 100) return Json(Json::value_t::discarded);
  }
  return Json::parse(text, nullptr, false);
}

constexpr double unlimited = std::numeric_limits<double>::infinity();

std::vector<Mark> marks_from(const Json& json) {
  std::vector<Mark> marks;
  for (const auto& entry : json)
    marks.push_back({entry.at("label").get<std::string>(), entry.at("begin").get<double>(), entry.value("run", 1),
                     entry.value("end", unlimited)});
  return marks;
}

std::map<std::string, std::string> meta_from(const Json& json) {
  std::map<std::string, std::string> meta;
  if (!json.is_object()) throw Json::other_error::create(501, "not an object", &json);
  for (const auto& [key, value] : json.items())
    meta[key] = value.is_string() ? value.get<std::string>() : json_text(value);
  return meta;
}

}  // namespace

bool kind_named(std::string_view text, QuantityKind& kind) {
  for (int i = 0; i <= static_cast<int>(QuantityKind::other); ++i)
    if (name(static_cast<QuantityKind>(i)) == text) {
      kind = static_cast<QuantityKind>(i);
      return true;
    }
  return false;
}

std::map<std::string, std::string> annotations_of(const Recording& recording) {
  std::map<std::string, std::string> texts;
  if (!recording.instrument.empty()) texts["instrument"] = json_text(Json(recording.instrument));
  if (!recording.meta.empty()) texts["meta"] = json_text(Json(recording.meta));
  Json marks = Json::array();
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    const Mark& mark = recording.marks[m];
    marks.push_back({{"label", mark.label}, {"begin", mark.begin}, {"run", mark.run}});
    const double next = m + 1 < recording.marks.size() ? recording.marks[m + 1].begin : unlimited;
    if (mark.end < next) marks.back()["end"] = mark.end;  // other segments end where the next one begins
  }
  if (!marks.empty()) texts["marks"] = json_text(marks);
  Json quantities = Json::object();
  for (const Channel& channel : recording.channels)
    if (channel.kind != kind_of(channel.unit)) quantities[channel.name] = name(channel.kind);
  if (!quantities.empty()) texts["quantities"] = json_text(quantities);
  return texts;
}

bool annotate(Recording& recording, std::map<std::string, QuantityKind>& kinds, std::string_view key,
              std::string_view json) {
  const Json value = parsed(json);
  if (value.is_discarded()) return false;
  try {
    if (key == "instrument") {
      recording.instrument = value.get<std::string>();
    } else if (key == "marks") {
      recording.marks = marks_from(value);
    } else if (key == "meta") {
      recording.meta = meta_from(value);
      for (auto& finding : recorded_findings(recording.meta)) recording.findings.push_back(std::move(finding));
    } else if (key == "quantities") {
      auto all = kinds;
      for (const auto& [channel, word] : value.items())
        if (!kind_named(word.get<std::string>(), all[channel])) return false;
      kinds = std::move(all);
    } else {
      return false;
    }
  } catch (const Json::exception&) {
    return false;
  }
  return true;
}

std::string all_annotations(const Recording& recording) {
  std::string text;
  for (const auto& [key, json] : annotations_of(recording))
    text += (text.empty() ? "{\"" : ", \"") + key + "\": " + json;
  return text.empty() ? "{}" : text + "}";
}

bool annotate_all(Recording& recording, std::string_view json) {
  const Json value = parsed(json);
  if (!value.is_object()) return false;
  std::map<std::string, QuantityKind> kinds;
  std::map<std::string, std::string> others;
  for (const auto& [key, entry] : value.items())
    if (!annotate(recording, kinds, key, json_text(entry)))
      others[key] = entry.is_string() ? entry.get<std::string>() : json_text(entry);
  for (auto& [key, text] : others) recording.meta.emplace(key, std::move(text));
  return true;
}

}  // namespace tumble::file
