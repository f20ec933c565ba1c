#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "tumble/exchange/exports/c_code/model.hpp"
#include "tumble/exchange/exports/export.hpp"
#include "tumble/exchange/exports/writing/text.hpp"
#include "tumble/units/error.hpp"

namespace tumble::exports::c {
namespace {

using namespace writing;

constexpr const char* default_name = "tumble_compensate";

std::vector<std::string> carries() {
  auto names =
      terms_ending({"bias", "scale_factor", "misalignment", "nonlinearity", "thermal_bias", "thermal_scale_factor"});
  names.emplace_back("gyro_acceleration_sensitivity");
  return names;
}

std::vector<Option> options() {
  return {word("type", {"double", "float", "fixed"})
              .otherwise("float")
              .says("type of the numbers; fixed: 32-bit integers whose formats follow from the ranges"),
          word("scale_factor", {"terms", "table"})
              .otherwise("terms")
              .says("of gyros: the terms of the results, or the departures at the rates of the test, interpolated, in "
                    "place of asymmetry and odd powers"),
          text("function").otherwise(default_name).says("name of the function")};
}

bool is_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

/// Whether a text has the name as a whole word.
bool has_word(std::string_view text, std::string_view name) {
  for (auto at = text.find(name); at != text.npos; at = text.find(name, at + 1)) {
    const auto end = at + name.size();
    if ((at == 0 || !is_letter(text[at - 1])) && (end == text.size() || !is_letter(text[end]))) return true;
  }
  return false;
}

/// A name that C takes for a function, in every edition of the standard. `code` has the default name.
void check_name(const std::string& name, std::string_view code) {
  const auto refuse = [&](const char* why) {
    throw Error(Error::Kind::bad_input, say("function = '{}' {}", name, why));
  };
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) || !std::ranges::all_of(name, is_letter))
    refuse("cannot be used: a name of C has letters, digits and _, and begins with a letter");
  if (name[0] == '_') refuse("cannot be used: names that begin with _ belong to the compiler");
  constexpr std::string_view taken[] = {
      "alignas", "alignof",       "asm",           "auto",     "bool",     "break",        "case",   "char",
      "const",   "constexpr",     "continue",      "default",  "do",       "double",       "else",   "enum",
      "extern",  "false",         "float",         "for",      "goto",     "if",           "inline", "int",
      "long",    "main",          "nullptr",       "register", "restrict", "return",       "short",  "signed",
      "sizeof",  "static",        "static_assert", "struct",   "switch",   "thread_local", "true",   "typedef",
      "typeof",  "typeof_unqual", "union",         "unsigned", "void",     "volatile",     "while"};
  if (std::ranges::find(taken, name) != std::end(taken)) refuse("is a word of C: choose another name");
  if (name != default_name && has_word(code, name)) refuse("is a name that the file uses itself: choose another one");
}

/// With the departures that were measured, where these are asked for.
ImuCalibration as_asked(ImuCalibration calibration, const Settings& settings) {
  if (settings.word("scale_factor") == "table" && !take_measured(calibration.gyros))
    throw Error(Error::Kind::bad_input,
                "c: scale_factor = table needs a result of gyro_scale_factor with three rates or more, identified by "
                "this version");
  return calibration;
}

std::string write(const ImuCalibration& given, const Settings& settings, const std::vector<std::string>& header) {
  const ImuCalibration calibration = as_asked(given, settings);
  require_calibration(calibration, "c");
  c_code::Plan plan{.name = default_name};
  const std::string& type = settings.word("type");
  plan.number = type == "double"  ? c_code::Number::double_precision
                : type == "float" ? c_code::Number::single_precision
                                  : c_code::Number::fixed;
  const double rounding = plan.number == c_code::Number::double_precision ? 1e-17 : 1e-9;
  plan.force_passes = c_code::passes_of(calibration.accelerometers, "accelerometer", rounding);
  plan.rate_passes = c_code::passes_of(calibration.gyros, "gyro", rounding);
  std::string text = "/*\n";
  for (const auto& line : header) text += " * " + line + "\n";
  if (settings.word("scale_factor") == "table")
    text += " * q of the gyros: the departures at the rates of the test, straight between them and constant beyond\n";
  text += " *\n * self-test: cc -std=c99 -DTUMBLE_CAL_TEST FILE.c && ./a.out\n */\n";
  const std::string code = plan.number == c_code::Number::fixed ? c_code::fixed_point(calibration, plan)
                                                                : c_code::floating_point(calibration, plan);
  const std::string& name = settings.word("function");
  check_name(name, code);
  return text + c_code::filled(code, {{default_name, name}});
}

}  // namespace

extern const Export c{
    .name = "c",
    .summary = "C99 source without libm and malloc, with test vectors and a self-test",
    .formula =
        "u = (1 + c(T)) u_r - e(T) with u_r = inv(K) (y - t(T) - b - G f - q(u_r)), solved by a fixed number of "
        "passes where q is not zero",
    .units = "outputs as calibrated; m/s^2, rad/s, degC",
    .frame = "axes of the calibration",
    .source = "this program; compared with tumble compensate by its tests",
    .comment = "*",
    .extension = ".c",
    .carries = carries,
    .estimates = no_terms,
    .takes_counts = true,
    .options = options,
    .write = write};

}  // namespace tumble::exports::c
