#include "tumble/report/problem_json.hpp"

#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/language/said.hpp"

namespace tumble {

namespace {

using ProblemJson = nlohmann::ordered_json;
using ValueKind = SentenceValue::Kind;

ProblemJson json_of_said(const Sentence& said);

ProblemJson json_of_value(const SentenceValue& value) {
  if (value.kind == ValueKind::sentence && !value.nested.empty()) return json_of_said(value.nested.front());
  ProblemJson json{{value.kind == ValueKind::name ? "name" : "text", value.text}};
  if (value.kind == ValueKind::number) json["number"] = value.number;
  if (!value.names.empty()) json["names"] = value.names;
  return json;
}

ProblemJson json_of_said(const Sentence& said) {
  ProblemJson values = ProblemJson::array();
  for (const SentenceValue& value : said.values) values.push_back(json_of_value(value));
  return {{"pattern", said.pattern}, {"values", std::move(values)}};
}

Sentence said_of_json(const ProblemJson& json);

SentenceValue value_of_json(const ProblemJson& json) {
  if (json.contains("pattern")) {
    Sentence nested = said_of_json(json);
    return {ValueKind::sentence, nested.text(), 0.0, {nested}};
  }
  if (json.contains("name"))
    return {ValueKind::name, json.at("name"), 0.0, {}, json.value("names", std::vector<std::string>())};
  const auto number = json.find("number");
  if (number == json.end()) return {ValueKind::text, json.at("text"), 0.0, {}};
  return {ValueKind::number, json.at("text"), number->is_number() ? number->get<double>() : 0.0, {}};
}

Sentence said_of_json(const ProblemJson& json) {
  Sentence said;
  said.pattern = json.at("pattern");
  for (const auto& value : json.at("values")) said.values.push_back(value_of_json(value));
  return said;
}

ProblemJson json_of_where(const Where& where) {
  ProblemJson json = ProblemJson::object();
  if (!where.file.empty()) json["file"] = where.file;
  if (where.line > 0) json["line"] = where.line;
  if (where.column > 0) json["column"] = where.column;
  if (!where.table.empty()) json["table"] = where.table;
  if (!where.key.empty()) json["key"] = where.key;
  if (!where.channel.empty()) json["channel"] = where.channel;
  if (where.time) json["time"] = *where.time;
  if (!where.place.empty()) json["place"] = json_of_said(where.place);
  return json;
}

Where where_of_json(const ProblemJson& json) {
  Where where{.file = json.value("file", ""),
              .line = json.value("line", std::size_t{0}),
              .column = json.value("column", std::size_t{0}),
              .table = json.value("table", ""),
              .key = json.value("key", ""),
              .channel = json.value("channel", "")};
  if (json.contains("time")) where.time = json.at("time").get<double>();
  if (json.contains("place")) where.place = said_of_json(json.at("place"));
  return where;
}

}  // namespace

std::string_view code_of(Error::Kind kind) {
  switch (kind) {
    case Error::Kind::bad_input:
      return "bad_input";
    case Error::Kind::bad_data:
      return "bad_data";
    case Error::Kind::bad_file:
      return "bad_file";
    case Error::Kind::unsupported:
      return "unsupported";
    case Error::Kind::internal:
      break;
  }
  return "internal";
}

std::string problems_to_json(std::string_view code, const Problems& problems, Language language) {
  ProblemJson all = ProblemJson::array();
  for (const Problem& problem : problems) {
    ProblemJson json{{"code", code}, {"message", in_language(language, problem)}};
    json.update(json_of_said(problem.what));
    json["where"] = json_of_where(problem.where);
    all.push_back(std::move(json));
  }
  return json_text(all);
}

std::string sentence_to_json(const Sentence& said) {
  const bool is_text = said.pattern == "{}" && !said.values.empty() && said.values.front().kind == ValueKind::text;
  return said.empty() || is_text ? std::string() : json_text(json_of_said(said));
}

Sentence sentence_from_json(const std::string& text) try {
  return said_of_json(ProblemJson::parse(text));
} catch (const ProblemJson::exception& error) {
  throw Error(Error::Kind::bad_file, say("a sentence cannot be read: {}", error.what()));
}

CodedProblems coded_problems_from_json(const std::string& text) try {
  CodedProblems found;
  for (const auto& json : ProblemJson::parse(text)) {
    if (found.code.empty()) found.code = json.at("code");
    found.problems.emplace_back(where_of_json(json.at("where")), said_of_json(json));
  }
  return found;
} catch (const ProblemJson::exception& error) {
  throw Error(Error::Kind::bad_file, say("problems cannot be read: {}", error.what()));
}

}  // namespace tumble
