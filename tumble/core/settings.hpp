#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/core/option.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {

/// One `key = value` as it was given, before anything is believed of it.
struct Given {
  std::string key;
  std::string text;
  Where where;                ///< "plan.toml:12", with file and line, or "--set"
  bool quoted = true;         ///< false: a TOML integer, float or boolean stood there, not a string
  bool command_line = false;  ///< from --set

  Given(std::string name, std::string written, Where at, bool in_quotes = true, bool from_command_line = false)
      : key(std::move(name)),
        text(std::move(written)),
        where(std::move(at)),
        quoted(in_quotes),
        command_line(from_command_line) {}
  /// At a place that is no line of a file: "--set".
  Given(std::string name, std::string written, const char* place, bool in_quotes = true, bool from_command_line = false)
      : Given(std::move(name), std::move(written), Where{.place = place}, in_quotes, from_command_line) {}
};

/// Checked values by name. A function that returns the value of a name throws Error::internal where the options do not
/// list the name, or it has no value: such a call is a bug of the program.
class Settings {
 public:
  bool has(std::string_view name) const;
  double number(std::string_view name) const;  ///< [SI]
  int integer(std::string_view name) const;
  const std::string& word(std::string_view name) const;  ///< also for text
  bool flag(std::string_view name) const;
  const std::vector<int>& integers(std::string_view name) const;

  /// Every value as text, defaults included: for provenance.
  const std::map<std::string, std::string>& texts() const { return texts_; }

  /// Sets a value [SI] that people are shown in `shown_in`; the others likewise.
  void set_number(const std::string& name, double value_si, const Unit& shown_in);
  void set_integer(const std::string& name, int value);
  void set_word(const std::string& name, std::string value);
  void set_flag(const std::string& name, bool value);
  void set_integers(const std::string& name, std::vector<int> values);

 private:
  std::map<std::string, double, std::less<>> numbers_;
  std::map<std::string, int, std::less<>> integers_;
  std::map<std::string, std::string, std::less<>> words_;
  std::map<std::string, std::vector<int>, std::less<>> lists_;
  std::map<std::string, std::string> texts_;
};

/// Checks what was given against what is accepted and fills in the defaults. Every problem (unknown key with the
/// nearest known one, wrong dimension, bare number, unknown word, not a number) is appended to `problems`, with where
/// it stands; the returned settings are complete only if none was.
/// `what` names the owner in messages: "method allan_noise", "rig thermal_chamber".
Settings resolve(const std::vector<Option>& options, const std::vector<Given>& given, std::string_view what,
                 Problems& problems);

/// The defaults alone.
Settings defaults(const std::vector<Option>& options);

}  // namespace tumble
