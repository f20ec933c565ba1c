#include "tumble/report/json_object.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace tumble {
namespace {

nlohmann::ordered_json& member_of(void* json, const char* key) {
  return (*static_cast<nlohmann::ordered_json*>(json))[key];
}

nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

void JsonObject::number(const char* key, double value) const { member_of(json_, key) = finite_or_null(value); }

void JsonObject::numbers(const char* key, const std::vector<double>& values) const {
  auto array = nlohmann::ordered_json::array();
  for (const double value : values) array.push_back(finite_or_null(value));
  member_of(json_, key) = std::move(array);
}

void JsonObject::whole(const char* key, unsigned long long value) const { member_of(json_, key) = value; }

void JsonObject::flag(const char* key, bool value) const { member_of(json_, key) = value; }

void JsonObject::text(const char* key, const std::string& value) const { member_of(json_, key) = value; }

void JsonObject::texts(const char* key, const std::vector<std::string>& values) const {
  member_of(json_, key) = values;
}

void JsonObject::lists(const char* key, const std::vector<std::vector<std::string>>& values) const {
  member_of(json_, key) = values;
}

void JsonObject::null(const char* key) const { member_of(json_, key) = nullptr; }

void JsonObject::json(const char* key, const std::string& text) const {
  member_of(json_, key) = nlohmann::ordered_json::parse(text);
}

JsonObject JsonObject::object(const char* key) const {
  auto& member = member_of(json_, key);
  member = nlohmann::ordered_json::object();
  return JsonObject(&member);
}

std::vector<JsonObject> JsonObject::objects(const char* key, std::size_t count) const {
  auto& member = member_of(json_, key);
  member = std::vector(count, nlohmann::ordered_json::object());
  std::vector<JsonObject> objects;
  for (auto& element : member) objects.emplace_back(&element);
  return objects;
}

}  // namespace tumble
