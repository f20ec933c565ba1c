#include "tumble/report/json_node.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

const nlohmann::json& json_of(const void* value) { return *static_cast<const nlohmann::json*>(value); }

double number_of(const nlohmann::json& value, double null_means) {
  return value.is_null() ? null_means : value.get<double>();
}

}  // namespace

void Node::complain(const Sentence& what) const {
  problems_->push_back({Where{.key = path_, .place = say("{}", Name{path_.empty() ? "top" : path_})}, what});
}

bool Node::expect(bool right_type, const char* expected) const {
  if (!right_type) complain(say("{} is expected, not {}", expected, Name{json_of(value_).type_name()}));
  return right_type;
}

Node Node::optional(const char* key) const {
  const Node missing{nullptr, path_.empty() ? key : path_ + "." + key, problems_};
  if (absent() || !json_of(value_).is_object()) return missing;
  const auto found = json_of(value_).find(key);
  if (found == json_of(value_).end() || found->is_null()) return missing;
  return {&*found, missing.path_, problems_};
}

Node Node::operator[](const char* key) const {
  if (absent() || !expect(json_of(value_).is_object(), "an object")) return {nullptr, path_, problems_};
  const Node member{nullptr, path_.empty() ? key : path_ + "." + key, problems_};
  const auto found = json_of(value_).find(key);
  if (found == json_of(value_).end()) {
    member.complain("is missing");
    return member;
  }
  return {&*found, member.path_, problems_};
}

std::vector<Node> Node::elements() const {
  std::vector<Node> nodes;
  if (absent() || !expect(json_of(value_).is_array(), "an array")) return nodes;
  nodes.reserve(json_of(value_).size());
  for (std::size_t i = 0; i < json_of(value_).size(); ++i) {
    nodes.emplace_back(&json_of(value_)[i], fmt::format("{}[{}]", path_, i), problems_);
  }
  return nodes;
}

std::vector<std::pair<std::string, std::string>> Node::members() const {
  std::vector<std::pair<std::string, std::string>> texts;
  if (absent() || !expect(json_of(value_).is_object(), "an object")) return texts;
  for (const auto& [key, item] : json_of(value_).items()) {
    texts.emplace_back(key, Node{&item, path_ + "." + key, problems_}.text());
  }
  return texts;
}

std::vector<std::string> Node::names() const {
  std::vector<std::string> keys;
  if (absent() || !expect(json_of(value_).is_object(), "an object")) return keys;
  for (const auto& [key, item] : json_of(value_).items()) keys.push_back(key);
  return keys;
}

std::string Node::text() const {
  if (absent() || !expect(json_of(value_).is_string(), "a text")) return {};
  return json_of(value_).get<std::string>();
}

bool Node::is_text() const { return !absent() && json_of(value_).is_string(); }

bool Node::is_whole() const {
  constexpr auto most = static_cast<unsigned long long>(std::numeric_limits<long long>::max());
  if (absent() || !json_of(value_).is_number_integer()) return false;
  return !json_of(value_).is_number_unsigned() || json_of(value_).get<unsigned long long>() <= most;
}

long long Node::integer() const { return is_whole() ? json_of(value_).get<long long>() : 0; }

bool Node::is_object() const { return !absent() && json_of(value_).is_object(); }

double Node::number(double null_means) const {
  if (absent()) return null_means;
  if (!expect(json_of(value_).is_number() || json_of(value_).is_null(), "a number (or null)")) return null_means;
  return number_of(json_of(value_), null_means);
}

std::vector<double> Node::numbers() const {
  std::vector<double> result;
  if (absent() || !expect(json_of(value_).is_array(), "an array")) return result;
  result.reserve(json_of(value_).size());
  for (const auto& item : json_of(value_)) {
    if (!item.is_number() && !item.is_null()) {
      complain(say("[{}]: a number (or null) is expected, not {}", result.size(), Name{item.type_name()}));
    }
    result.push_back(item.is_number() ? number_of(item, NAN) : NAN);
  }
  return result;
}

unsigned long long Node::whole() const {
  if (absent() || !expect(json_of(value_).is_number_unsigned(), "a whole number, not negative,")) return 0;
  return json_of(value_).get<unsigned long long>();
}

bool Node::flag() const {
  if (absent() || !expect(json_of(value_).is_boolean(), "true or false")) return false;
  return json_of(value_).get<bool>();
}

std::string Node::json() const { return absent() ? std::string() : json_of(value_).dump(); }

std::size_t Node::one_of(const std::vector<std::string>& words) const {
  if (absent() || !expect(json_of(value_).is_string(), "a text")) return 0;
  const auto word = json_of(value_).get<std::string>();
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == word) return i;
  }
  complain(say("'{}' is not one of {}", word, fmt::join(words, ", ")));
  return 0;
}

Unit unit_of(const Node& node) {
  if (node.absent()) return {};
  try {
    return Unit::parse(node.text());
  } catch (const Error& error) {
    node.complain(reason_of(error));
    return {};
  }
}

}  // namespace tumble
