#pragma once

#include <nlohmann/json.hpp>

#include "tumble/report/members.hpp"

namespace tumble::testing {

/// The JSON schema of a type with members, as OpenAPI has it.
class MemberSchema {
 public:
  template <class T, class... Further>
  MemberSchema& operator()(const char* key, const T& value, const Further&... further) {
    if constexpr (!requires { value.has_value(); }) schema["required"].push_back(key);
    schema["properties"][key] = schema_of(value, further...);
    return *this;
  }
  template <class T, class... Further>
  MemberSchema& optional(const char* key, const T& value, bool, const Further&... further) {
    schema["properties"][key] = schema_of(value, further...);
    return *this;
  }
  MemberSchema& index(const char* key, const std::optional<std::size_t>& value) { return (*this)(key, value); }
  void complain(const char*, const Sentence&) {}

  nlohmann::json schema = {{"type", "object"}, {"required", nlohmann::json::array()}};

 private:
  template <class T, class... Further>
  static nlohmann::json schema_of(const T& value, const Further&... further) {
    if constexpr (HasMembers<const T, MemberSchema>) {
      MemberSchema inner;
      members(inner, value);
      return inner.schema;
    } else if constexpr (std::same_as<T, bool>) {
      return {{"type", "boolean"}};
    } else if constexpr (WholeNumber<T>) {
      return {{"type", "integer"}};
    } else if constexpr (std::same_as<T, double>) {
      return {{"type", "number"}};
    } else if constexpr (std::is_enum_v<T>) {
      return {{"type", "string"}, {"enum", EnumerationWords{further...}}};
    } else if constexpr (requires { value.has_value(); }) {
      return schema_of(value.value_or(typename T::value_type()));
    } else if constexpr (std::same_as<T, CodedProblems>) {
      return {{"type", "array"}, {"items", {{"type", "object"}}}};
    } else if constexpr (std::same_as<T, std::string> || std::same_as<T, Unit>) {
      return {{"type", "string"}};
    } else {
      return {{"type", "array"}, {"items", schema_of(typename T::value_type())}};
    }
  }
};

/// The schema of a type, from a value without content.
template <class T>
nlohmann::json schema_of() {
  MemberSchema visit;
  const T value{};
  members(visit, value);
  return visit.schema;
}

}  // namespace tumble::testing
