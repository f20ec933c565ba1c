#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tumble/units/sentence.hpp"

namespace tumble {

/// Values that a number may have, in the option's own unit; an end that is open does not belong to it.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool least_open = false;
  bool most_open = false;
};

/// One thing a method, rig or model accepts, as a user may set it in a plan or by --set. Made by one of the functions
/// below, then described:
///
///   quantity("level_sd", "%").at_least(0).otherwise("1 %").says("standard uncertainty of the level")
///   integer("terms").between(1, 8).otherwise("6").says("terms of the model")
///   word("level_from", {"plan", "reference"}).otherwise("plan").says("what gives the level")
struct Option {
  enum class Type { quantity, integer, word, flag, integers, text };
  std::string name;
  Type type = Type::quantity;
  std::string unit = "1";          ///< quantity: its dimension, and the unit it is shown in
  std::string fallback;            ///< default, written as a user would; empty: none (see Settings::has)
  std::vector<std::string> words;  ///< word: what is accepted
  std::string description;
  bool bare_on_command_line = false;  ///< `--set rate=100` may omit the unit
  Range range;                        ///< of a quantity, an integer and each of several integers

  // Ends of the range [unit of the option].
  Option& above(double least);                 ///< [unit of the option]
  Option& at_least(double least);              ///< [unit of the option]
  Option& below(double most);                  ///< [unit of the option]
  Option& at_most(double most);                ///< [unit of the option]
  Option& between(double least, double most);  ///< [unit of the option]; both ends belong to it

  Option& otherwise(std::string text);  ///< the default
  Option& bare();                       ///< `--set` may omit the unit
  Option& says(std::string text);       ///< the description
};

/// A number with a unit; finite.
Option quantity(std::string name, std::string unit = "1");
Option integer(std::string name);
/// "1,2,5-8"
Option integers(std::string name);
/// One of these words.
Option word(std::string name, std::vector<std::string> words);
/// true or false, false where nothing is said.
Option flag(std::string name);
Option text(std::string name);

/// The range in words, for a sentence: "above 0 g", "between 0 and 20"; empty where every number may be.
Sentence said_of(const Range& range, const std::string& unit);
std::string name(const Range& range, const std::string& unit);

}  // namespace tumble
