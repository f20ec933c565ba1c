#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// A piece of a sentence by its key in [phrase] of text/en.toml, so that every language can say it. A method, rig or
/// check of your own that stands in one file gives its English beside the key.
struct Phrase {
  std::string key;
  std::string english = {};  ///< empty: as the table has it
};

/// A value that a finding speaks of.
struct FindingValue {
  std::string name;                                            ///< in the sentence and in the JSON
  std::variant<double, long long, std::string, Phrase> value;  ///< a number is [SI]; a string is a name, said as it is
  Unit unit;                                                   ///< that people are shown

  /// Given: value [SI], and the unit to show it in.
  FindingValue(std::string what, double value_si, const Unit& shown_in)
      : name(std::move(what)), value(value_si), unit(shown_in) {}
  FindingValue(std::string what, double value_si, std::string_view shown_in = "1")
      : FindingValue(std::move(what), value_si, Unit::parse(shown_in)) {}
  FindingValue(std::string what, std::integral auto count)
      : name(std::move(what)), value(static_cast<long long>(count)) {}
  FindingValue(std::string what, std::string text) : name(std::move(what)), value(std::move(text)) {}
  FindingValue(std::string what, const char* text) : FindingValue(std::move(what), std::string(text)) {}
  FindingValue(std::string what, Phrase phrase) : name(std::move(what)), value(std::move(phrase)) {}
};

/// Where one occurrence of a finding is.
struct Place {
  std::string label;           ///< a segment, a position, a frequency; empty: the time says it
  double time = std::nan("");  ///< [s] on the recording's clock; NaN: the label says it

  Place() = default;
  Place(double time_s) : time(time_s) {}  ///< [s]
  Place(std::string text) : label(std::move(text)) {}
  Place(std::string text, double time_s) : label(std::move(text)), time(time_s) {}  ///< [s]
  bool given() const { return !label.empty() || std::isfinite(time); }
};

/// How often a finding was made, and where first and worst.
struct Occurrences {
  std::size_t count = 1;
  Place first, worst;
};

/// A problem of the data, or a weakness of the answer. Not an error: the work was carried out.
///
/// The code names the problem, the values give its size; the sentence is made from these by text/en.toml, so that
/// programs need no sentence and languages no code.
struct Finding {
  enum class Severity { info, warning, error };  ///< error: do not rely on what it names
  Severity severity = Severity::warning;
  std::string code;     ///< key in [finding] of text/en.toml: "gap"; empty: read from a file without codes
  std::string message;  ///< what, and what would mend it, in English
  std::string where;    ///< channel, run, time, file: empty where it concerns the whole
  std::vector<FindingValue> values;
  Occurrences occurrences;

  Finding() = default;
  Finding(Severity how_severe, std::string what, std::vector<FindingValue> with, std::string place = "",
          Occurrences often = {});
  /// With a sentence that text/en.toml lacks; it may hold what `sentence` says.
  Finding(Severity how_severe, Phrase what, std::vector<FindingValue> with, std::string place = "",
          Occurrences often = {});
};

using Findings = std::vector<Finding>;

/// The sentence of a finding: its template in text/en.toml with its values.
///
/// `{name}` is replaced by the value of that name, {count}, {first} and {worst} for the occurrences; what follows a
/// colon says how it is written:
///   {rate}             four digits, in the unit of the value
///   {rate:.3g}         other digits
///   {rate:.4g deg/h}   in another unit
///   {rate:.4g -}       without its unit
///   {rate:exact}       all digits
///   {rise:difference}  three digits, as a difference (a temperature without its zero)
///   {length:duration}  310 ms, 12.5 s
///   {begin:instant}    812.4 s
///   {lost:sample}      1 sample, 3 samples
///   {size:bytes}       1.5 GB
/// A code with `one` and `other` has two templates, chosen by the count.
/// Throws Error::internal for a code that the table lacks, or a template that names an absent value.
std::string sentence(const Finding& finding);

/// A sentence with placeholders as above, filled with the values of a finding.
/// Throws Error::internal if it names an absent value.
std::string filled(const std::string& sentence, const Finding& finding);

/// The message of a finding as a sentence of its pattern and its values.
Sentence said_of(const Finding& finding);

/// The errors among them as the problems of a refusal: "where: message".
Problems errors_among(const Findings& findings);

}  // namespace tumble
