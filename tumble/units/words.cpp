#include "tumble/units/words.hpp"

#include <array>
#include <vector>

#include "tumble/units/nearest.hpp"

namespace tumble {

namespace {

/// A word of the table. The exponents of the dimension are whole; `factor` is numerator / denominator * pi^pi_power.
struct Word {
  std::string_view text;
  std::string_view prefixes;  ///< those it takes, as one letter each; "u" stands for micro in any spelling
  std::array<signed char, Dimension::bases> powers;  ///< m kg s A K rad count
  long numerator = 1, denominator = 1;
  int pi_power = 0;
  double offset = 0.0;
};

constexpr std::string_view none, small = "munp", all = "TGMkhdcmunp";

constexpr std::array<signed char, Dimension::bases> one{}, length{1}, mass{0, 1}, duration{0, 0, 1},
    current{0, 0, 0, 1}, temperature{0, 0, 0, 0, 1}, angle{0, 0, 0, 0, 0, 1}, number{0, 0, 0, 0, 0, 0, 1},
    frequency{0, 0, -1}, angular_rate{0, 0, -1, 0, 0, 1}, acceleration{1, 0, -2}, force{1, 1, -2}, pressure{-1, 1, -2},
    energy{2, 1, -2}, power{2, 1, -3}, voltage{2, 1, -3, -1}, resistance{2, 1, -3, -2}, flux_density{0, 1, -2, -1};

/// SI brochure (9th ed., 2019) for the coherent units; g is the standard acceleration of free fall (3rd CGPM, 1901).
constexpr Word words[] = {
    {"1", none, one},
    {"%", none, one, 1, 100},
    {"ppm", none, one, 1, 1'000'000},
    {"ppb", none, one, 1, 1'000'000'000},
    {"m", all, length},
    {"kg", none, mass},
    {"s", small, duration},
    {"sec", small, duration},
    {"second", none, duration},
    {"seconds", none, duration},
    {"秒", none, duration},
    {"millisecond", none, duration, 1, 1000},
    {"milliseconds", none, duration, 1, 1000},
    {"毫秒", none, duration, 1, 1000},
    {"microsecond", none, duration, 1, 1'000'000},
    {"microseconds", none, duration, 1, 1'000'000},
    {"nanosecond", none, duration, 1, 1'000'000'000},
    {"nanoseconds", none, duration, 1, 1'000'000'000},
    {"min", none, duration, 60},
    {"minute", none, duration, 60},
    {"minutes", none, duration, 60},
    {"h", none, duration, 3600},
    {"hr", none, duration, 3600},
    {"hour", none, duration, 3600},
    {"hours", none, duration, 3600},
    {"day", none, duration, 86400},
    {"days", none, duration, 86400},
    {"A", all, current},
    {"K", small, temperature},
    {"kelvin", none, temperature},
    {"degC", none, temperature, 1, 1, 0, 273.15},
    {"°C", none, temperature, 1, 1, 0, 273.15},
    {"ºC", none, temperature, 1, 1, 0, 273.15},
    {"℃", none, temperature, 1, 1, 0, 273.15},
    {"celsius", none, temperature, 1, 1, 0, 273.15},
    {"Celsius", none, temperature, 1, 1, 0, 273.15},
    {"degF", none, temperature, 5, 9, 0, 45967.0 / 180.0},
    {"°F", none, temperature, 5, 9, 0, 45967.0 / 180.0},
    {"℉", none, temperature, 5, 9, 0, 45967.0 / 180.0},
    {"rad", small, angle},
    {"radian", none, angle},
    {"radians", none, angle},
    {"deg", small, angle, 1, 180, 1},
    {"degree", none, angle, 1, 180, 1},
    {"degrees", none, angle, 1, 180, 1},
    {"°", small, angle, 1, 180, 1},
    {"º", small, angle, 1, 180, 1},
    {"arcmin", none, angle, 1, 10800, 1},
    {"arcsec", small, angle, 1, 648000, 1},
    {"rev", none, angle, 2, 1, 1},
    {"rpm", none, angular_rate, 1, 30, 1},
    {"dps", small, angular_rate, 1, 180, 1},
    {"g", small, acceleration, 196133, 20000},
    {"Gal", small, acceleration, 1, 100},
    {"Hz", all, frequency},
    {"N", all, force},
    {"Pa", all, pressure},
    {"bar", small, pressure, 100'000},
    {"J", all, energy},
    {"W", all, power},
    {"V", all, voltage},
    {"volt", none, voltage},
    {"volts", none, voltage},
    {"Volt", none, voltage},
    {"Volts", none, voltage},
    {"ohm", all, resistance},
    {"Ω", all, resistance},
    {"\u2126", all, resistance},
    {"T", small, flux_density},
    {"gauss", small, flux_density, 1, 10'000},
    {"pulse", none, number},
    {"pulses", none, number},
    {"count", none, number},
    {"counts", none, number},
    {"LSB", none, number},
    {"bit", none, number},
    {"bits", none, number},
};

/// Words that people write and that would be guessed wrongly.
constexpr struct {
  std::string_view text, advice;
} refused[] = {
    {"dB", ": a decibel is a logarithm, not a unit; write the plain ratio or quantity"},
    {"dBm", ": a decibel is a logarithm, not a unit; write the plain quantity"},
    {"C", ": write 'degC' for a temperature, 'A*s' for a charge"},
    {"F", ": write 'degF' for a temperature"},
    {"G", ": write 'g' for gravity, 'gauss' for a magnetic field"},
    {"M", ": write 'm' for metre, 'min' for minute"},
    {"S", ": write 's' for second"},
    {"H", ": write 'h' for hour"},
    {"d", ": write 'day', or 'deg'"},
    {"kh", ": write '1000 h' in the number"},
    {"gram", ": write 'kg'; 'g' is gravity and 'mg' a thousandth of it"},
};

constexpr struct {
  std::string_view text;
  char letter;
  int exponent;
} prefixes[] = {{"T", 'T', 12}, {"G", 'G', 9},  {"M", 'M', 6},  {"k", 'k', 3},  {"h", 'h', 2},
                {"d", 'd', -1}, {"c", 'c', -2}, {"m", 'm', -3}, {"u", 'u', -6}, {"µ", 'u', -6},
                {"μ", 'u', -6}, {"n", 'n', -9}, {"p", 'p', -12}};

Meaning meaning_of(const Word& word) {
  Meaning meaning;
  for (int i = 0; i < Dimension::bases; ++i) meaning.dimension.halves[i] = static_cast<signed char>(2 * word.powers[i]);
  meaning.factor = exact_factor(word.numerator, word.denominator, word.pi_power);
  meaning.offset = word.offset;
  return meaning;
}

}  // namespace

std::optional<Meaning> meaning_of(std::string_view text) {
  for (const Word& word : words)
    if (word.text == text) return meaning_of(word);
  for (const auto& prefix : prefixes) {
    if (!text.starts_with(prefix.text)) continue;
    for (const Word& word : words) {
      if (text.substr(prefix.text.size()) != word.text || word.prefixes.find(prefix.letter) == word.prefixes.npos)
        continue;
      Meaning meaning = meaning_of(word);
      meaning.factor = meaning.factor * power_of_ten(prefix.exponent);
      return meaning;
    }
  }
  return std::nullopt;
}

std::vector<UnitWord> unit_words() {
  std::vector<UnitWord> all;
  for (const Word& word : words) all.push_back({word.text, word.prefixes});
  return all;
}

Sentence advice_on(std::string_view text) {
  for (const auto& word : refused)
    if (word.text == text) return std::string(word.advice).c_str();
  std::vector<std::string> known;
  for (const Word& word : words) known.emplace_back(word.text);
  for (const Word& word : words)
    for (const char prefix : word.prefixes) known.push_back(prefix + std::string(word.text));
  const Sentence advice = did_you_mean(text, known);
  return advice.empty() ? Sentence("; known are for example deg rad arcsec h s Hz m g kg K degC V A pulse ppm")
                        : advice;
}

}  // namespace tumble
