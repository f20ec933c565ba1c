#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tumble/report/json_node.hpp"
#include "tumble/report/json_object.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/report/shown_value.hpp"
#include "tumble/units/error.hpp"

/// The members of a type are listed once for all that goes through them: JSON in both directions, its schema, and the
/// comparison of two values in tests. A type with such a list has this function in its namespace:
///
///   template <class Visitor, PossiblyConst<Fit> X>
///   void members(Visitor& visit, X& x) {
///     visit("observations", x.observations)("condition", x.condition, infinity);
///   }
///
/// A visitor is called with a key and a member. Behind them stands what a number means that is null, the unit [u] in
/// which numbers [SI] are written, or the words of an enumeration.
///   optional    written where it is needed alone, and may be missing where it is read
///   index       index of a parameter of the result
///   object      a part that is an object of its own; null where it is not there
///   complain    what is wrong with a member that was read
namespace tumble {

template <class X, class T>
concept PossiblyConst = std::same_as<std::remove_const_t<X>, T>;

template <class T, class Visitor>
concept HasMembers = requires(Visitor& visit, T& value) {
  members(visit, value);
};

template <class T>
concept WholeNumber = std::integral<T> && !std::same_as<T, bool>;

using EnumerationWords = std::vector<std::string>;

/// Writes members.
class MembersToJson {
 public:
  explicit MembersToJson(JsonObject object) : object_(object) {}

  /// A number that is not finite is null, which means `null_means` [as the value] where it is read.
  template <class T>
  MembersToJson& operator()(const char* key, const T& value, double /*null_means*/ = NAN) {
    write(key, value);
    return *this;
  }
  /// Given: values [SI], written in `unit`.
  MembersToJson& operator()(const char* key, const std::vector<double>& values, const Unit& unit) {
    std::vector<double> shown;
    for (const double value : values) shown.push_back(shown_value(value, unit));
    object_.numbers(key, shown);
    return *this;
  }
  template <class Enumeration>
  MembersToJson& operator()(const char* key, const Enumeration& value, const EnumerationWords& words) {
    object_.text(key, words[static_cast<std::size_t>(value)]);
    return *this;
  }
  template <class T, class... Further>
  MembersToJson& optional(const char* key, const T& value, bool needed, const Further&... further) {
    return needed ? (*this)(key, value, further...) : *this;
  }
  MembersToJson& index(const char* key, const std::optional<std::size_t>& value) { return (*this)(key, value); }
  template <class Part>
  MembersToJson& object(const char* key, bool there, const Part& part) {
    if (!there) return object_.null(key), *this;
    MembersToJson inner(object_.object(key));
    part(inner);
    return *this;
  }
  void complain(const char* /*key*/, const Sentence& /*what*/) {}

 private:
  void write(const char* key, double value) { object_.number(key, value); }
  void write(const char* key, const std::vector<double>& values) { object_.numbers(key, values); }
  void write(const char* key, bool value) { object_.flag(key, value); }
  void write(const char* key, WholeNumber auto value) { object_.whole(key, static_cast<unsigned long long>(value)); }
  void write(const char* key, const std::string& value) { object_.text(key, value); }
  void write(const char* key, const std::vector<std::string>& values) { object_.texts(key, values); }
  void write(const char* key, const std::vector<EnumerationWords>& lists) { object_.lists(key, lists); }
  void write(const char* key, const Unit& unit) { object_.text(key, unit.text()); }
  void write(const char* key, const CodedProblems& errors) {
    object_.json(key, problems_to_json(errors.code, errors.problems, Language::english));
  }
  template <class T>
  void write(const char* key, const std::optional<T>& value) {
    if (value) write(key, *value);
  }
  template <HasMembers<MembersToJson> T>
  void write(const char* key, const T& value) {
    MembersToJson inner(object_.object(key));
    members(inner, value);
  }
  template <HasMembers<MembersToJson> T>
  void write(const char* key, const std::vector<T>& values) {
    const auto objects = object_.objects(key, values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      MembersToJson inner(objects[i]);
      members(inner, values[i]);
    }
  }

  JsonObject object_;
};

/// Reads members. What is missing or wrong is complained of, and read as a harmless default.
class MembersFromJson {
 public:
  /// `parameters` of the result, below which an index must be.
  explicit MembersFromJson(Node node, std::size_t parameters = 0) : node_(std::move(node)), parameters_(parameters) {}

  template <class T, class... Further>
  MembersFromJson& operator()(const char* key, T& value, const Further&... further) {
    read(node_[key], value, further...);
    return *this;
  }
  template <class T>
  MembersFromJson& operator()(const char* key, std::optional<T>& value) {
    if (const Node node = node_.optional(key); !node.absent()) read(node, value.emplace());
    return *this;
  }
  template <class T, class... Further>
  MembersFromJson& optional(const char* key, T& value, bool /*needed*/, const Further&... further) {
    if (const Node node = node_.optional(key); !node.absent()) read(node, value, further...);
    return *this;
  }
  MembersFromJson& index(const char* key, std::optional<std::size_t>& value) {
    (*this)(key, value);
    if (value && *value >= parameters_)
      complain(key, say("is {}, but the result has {} parameters", *value, parameters_));
    return *this;
  }
  template <class Part>
  MembersFromJson& object(const char* key, bool /*there*/, const Part& part) {
    if (const Node node = node_.optional(key); !node.absent()) {
      MembersFromJson inner(node, parameters_);
      part(inner);
    }
    return *this;
  }
  void complain(const char* key, const Sentence& what) { node_[key].complain(what); }

 private:
  void read(const Node& node, double& value, double null_means = NAN) { value = node.number(null_means); }
  void read(const Node& node, std::vector<double>& values) { values = node.numbers(); }
  void read(const Node& node, std::vector<double>& values, const Unit& unit) {
    values = node.numbers();
    for (double& value : values) value = unit.to_si(value);
  }
  void read(const Node& node, bool& value) { value = node.flag(); }
  template <WholeNumber T>
  void read(const Node& node, T& value) {
    value = static_cast<T>(std::min<unsigned long long>(node.whole(), std::numeric_limits<T>::max()));
  }
  void read(const Node& node, std::string& value) { value = node.text(); }
  void read(const Node& node, std::vector<std::string>& values) {
    for (const Node& element : node.elements()) values.push_back(element.text());
  }
  void read(const Node& node, std::vector<EnumerationWords>& lists) {
    for (const Node& element : node.elements()) read(element, lists.emplace_back());
  }
  void read(const Node& node, CodedProblems& errors) {
    if (!node.absent()) errors = coded_problems_from_json(node.json());
  }
  void read(const Node& node, Unit& unit) {
    if (node.absent()) return;
    try {
      unit = Unit::parse(node.text());
    } catch (const Error& error) {
      node.complain(reason_of(error));
    }
  }
  template <class Enumeration>
  void read(const Node& node, Enumeration& value, const EnumerationWords& words) {
    value = static_cast<Enumeration>(node.one_of(words));
  }
  template <HasMembers<MembersFromJson> T>
  void read(const Node& node, T& value) {
    MembersFromJson inner(node, parameters_);
    members(inner, value);
  }
  template <HasMembers<MembersFromJson> T>
  void read(const Node& node, std::vector<T>& values) {
    for (const Node& element : node.elements()) read(element, values.emplace_back());
  }

  Node node_;
  std::size_t parameters_;
};

}  // namespace tumble
