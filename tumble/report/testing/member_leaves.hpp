#pragma once

#include <map>
#include <string>
#include <variant>

#include "tumble/report/members.hpp"

namespace tumble::testing {

/// The members of a value by their paths, "band.lower[3]", to compare two values. Whole numbers and flags are numbers.
class MemberLeaves {
 public:
  using Leaves = std::map<std::string, std::variant<double, std::string>>;

  MemberLeaves(Leaves& leaves, std::string path) : leaves_(leaves), path_(std::move(path)) {}

  template <class T, class... Further>
  MemberLeaves& operator()(const char* key, const T& value, const Further&...) {
    add(path_ + key, value);
    return *this;
  }
  template <class T, class... Further>
  MemberLeaves& optional(const char* key, const T& value, bool, const Further&...) {
    return (*this)(key, value);
  }
  MemberLeaves& index(const char* key, const std::optional<std::size_t>& value) { return (*this)(key, value); }
  template <class Part>
  MemberLeaves& object(const char* key, bool there, const Part& part) {
    MemberLeaves inner(leaves_, path_ + key + ".");
    if (there) part(inner);
    return *this;
  }
  void complain(const char*, const Sentence&) {}

 private:
  template <class T>
  void add(const std::string& path, const T& value) {
    if constexpr (HasMembers<const T, MemberLeaves>) {
      MemberLeaves inner(leaves_, path + ".");
      members(inner, value);
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      leaves_[path] = static_cast<double>(value);
    } else if constexpr (std::same_as<T, Unit>) {
      leaves_[path] = value.text();
    } else if constexpr (requires { value.has_value(); }) {
      if (value) add(path, *value);
    } else if constexpr (std::convertible_to<T, std::string>) {
      leaves_[path] = std::string(value);
    } else {
      for (std::size_t i = 0; i < value.size(); ++i) add(path + "[" + std::to_string(i) + "]", value[i]);
    }
  }

  Leaves& leaves_;
  std::string path_;
};

template <class T>
MemberLeaves::Leaves leaves_of(const T& value) {
  MemberLeaves::Leaves leaves;
  MemberLeaves visit(leaves, "");
  members(visit, value);
  return leaves;
}

}  // namespace tumble::testing
