#pragma once

#include <string>
#include <vector>

#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// A place in a JSON document that is being read. What is missing or of the wrong type is written down with its path
/// ("parameters[2].sd") and read as a harmless default, so that one pass finds every problem.
class Node {
 public:
  /// `value` points to an nlohmann::json that outlives the node, or is null.
  Node(const void* value, std::string path, Problems* problems)
      : value_(value), path_(std::move(path)), problems_(problems) {}

  /// A member that must be there.
  Node operator[](const char* key) const;
  /// A member that may be missing or null: then absent() is true and reads give defaults without complaint.
  Node optional(const char* key) const;
  bool absent() const { return value_ == nullptr; }

  std::vector<Node> elements() const;                                ///< of an array
  std::vector<std::pair<std::string, std::string>> members() const;  ///< of an object of texts
  std::string text() const;
  std::vector<std::string> names() const;  ///< of an object's members
  bool is_text() const;
  bool is_whole() const;      ///< an integer that a long long holds
  long long integer() const;  ///< 0 for another value
  bool is_object() const;
  double number(double null_means) const;  ///< [as written]; `null_means` for null
  std::vector<double> numbers() const;     ///< of an array [as written]; null reads as NaN
  unsigned long long whole() const;        ///< not negative
  bool flag() const;
  std::size_t one_of(const std::vector<std::string>& words) const;

  std::string json() const;  ///< its text again; empty where it is absent

  void complain(const Sentence& what) const;

 private:
  bool expect(bool right_type, const char* expected) const;

  const void* value_;  ///< a nlohmann::json: headers do not name the library
  std::string path_;
  Problems* problems_;
};

/// The unit that a node names; the unit 1 where it is absent or, with a problem, where it is no unit.
Unit unit_of(const Node& node);

}  // namespace tumble
