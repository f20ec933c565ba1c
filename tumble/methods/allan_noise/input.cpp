#include "tumble/methods/allan_noise/input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::allan_noise {
namespace {

const std::vector<std::string> named_taus{"log", "octave", "decade", "all"};

bool is_named(const std::string& taus) { return std::ranges::find(named_taus, taus) != named_taus.end(); }

/// "[1, 2 s, 10 min]" as words.
std::vector<std::string> listed_words(const std::string& text) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : text + ",") {
    if (c != ',' && c != '[' && c != ']' && c != '"') {
      word += c;
      continue;
    }
    if (!is_blank(word)) words.emplace_back(trimmed(word));
    word.clear();
  }
  return words;
}

/// [s] A bare number is in seconds. NaN: no time above zero.
double time_of_word(const std::string& word) {
  if (const auto value = as_number<double>(word)) return *value > 0.0 ? *value : std::nan("");
  try {
    const Quantity quantity = parse_quantity(word);
    if (quantity.unit.dimension() == Unit::parse("s").dimension() && quantity.value > 0.0)
      return quantity.unit.to_si(quantity.value);
  } catch (const Error&) {
    return std::nan("");
  }
  return std::nan("");
}

}  // namespace

Problems input_problems(const Settings& settings) {
  Problems problems;
  const bool counts = settings.word("data") == "count";
  if (counts != settings.has("pulse"))
    problems.push_back(counts ? "data = count needs the angle or velocity of a pulse: pulse = 0.5 arcsec, or 1 mm/s"
                              : "pulse is for data = count: say data = count, or leave it out");
  if (settings.has("pulse")) {
    const std::string& text = settings.word("pulse");
    try {
      const Quantity pulse = parse_quantity(text);
      const auto kind = kind_of(pulse.unit);
      if ((kind != QuantityKind::angle && kind != QuantityKind::velocity) || pulse.value == 0.0)
        problems.push_back(say("pulse = {} must be an angle or a velocity, as in 0.5 arcsec or 1 mm/s", Name{text}));
    } catch (const Error& error) {
      problems.push_back(say("pulse = {}: {}", Name{text}, reason_of(error)));
    }
  }
  const std::string& taus = settings.word("taus");
  if (is_named(taus)) return problems;
  const auto words = listed_words(taus);
  if (words.empty()) problems.push_back("taus must be log, octave, decade, all, or a list of times");
  for (const auto& word : words)
    if (std::isnan(time_of_word(word)))
      problems.push_back(
          say("taus: '{}' is no time above 0; accepted: log, octave, decade, all, or a list as in \"1 s, 10 s, "
              "2 min\" (a number alone is in seconds)",
              word));
  return problems;
}

ChannelsWanted channels_of_data(const Settings& settings) {
  const std::string& data = settings.word("data");
  const auto kinds = [](QuantityKind one, QuantityKind other) {
    return [one, other](const Channel& channel) { return channel.kind == one || channel.kind == other; };
  };
  if (data == "rate")
    return {kinds(QuantityKind::angular_rate, QuantityKind::specific_force),
            "an angular rate or a specific force, as in deg/h or m/s^2"};
  if (data == "phase") return {kinds(QuantityKind::time, QuantityKind::time), "a time error, as in s or ns"};
  if (data == "count") return {kinds(QuantityKind::count, QuantityKind::count), "counts, as in pulse or LSB"};
  if (data == "frequency")
    return {[](const Channel& channel) { return channel.unit.dimension() == Dimension{}; },
            "a fractional frequency: a number without a unit (1)"};
  return {kinds(QuantityKind::angle, QuantityKind::velocity), "an angle or a velocity, as in arcsec or m/s"};
}

QuantityKind kind_of_rate(const Channel& channel, const Settings& settings) {
  QuantityKind kind = channel.kind;
  if (settings.word("data") == "count") kind = kind_of(parse_quantity(settings.word("pulse")).unit);
  switch (kind) {
    case QuantityKind::angle:
      return QuantityKind::angular_rate;
    case QuantityKind::velocity:
      return QuantityKind::specific_force;
    case QuantityKind::time:
      return QuantityKind::other;
    default:
      return kind;
  }
}

EvenSignal rate_signal(const ChannelRun& stretch, const Settings& settings) {
  EvenSignal signal = from_start(
      even_signal(stretch, settings.has("rate") ? settings.number("rate") : 0.0, settings.word("timing")), settings);
  const std::string& data = settings.word("data");
  if (data == "rate" || data == "frequency" || !(signal.rate > 0.0) || signal.values.empty()) return signal;
  std::vector<double> values(signal.values.begin(), signal.values.end());
  if (data == "angle" || data == "phase") {
    for (std::size_t i = 0; i + 1 < values.size(); ++i) values[i] = (values[i + 1] - values[i]) * signal.rate;
    values.pop_back();
  } else {
    double factor = 1.0;
    if (data == "count") {
      const Quantity pulse = parse_quantity(settings.word("pulse"));
      factor = pulse.unit.to_si(pulse.value);
    }
    const auto missing = [&](std::size_t i) { return std::isnan(signal.values[i]); };
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = i > 0 && missing(i - 1) ? std::nan("") : values[i] * factor * signal.rate;
  }
  signal.made = std::move(values);
  signal.values = signal.made;
  signal.extremes = extremes_of(signal.made);
  return signal;
}

EvenSignal from_start(EvenSignal signal, const Settings& settings) {
  if (!settings.has("from") || !(signal.rate > 0.0)) return signal;
  const double from = settings.number("from");
  const auto out = static_cast<std::size_t>(std::min(std::ceil(from * signal.rate), 1e15));
  if (out >= signal.values.size())
    throw Error(Error::Kind::bad_data, say("from = {} leaves nothing of a record of {}", Name{say_seconds(from)},
                                           Name{say_seconds(static_cast<double>(signal.values.size()) / signal.rate)}));
  signal.values = signal.values.subspan(out);
  signal.begin += static_cast<double>(out) / signal.rate;
  signal.extremes = extremes_of(signal.values);
  return signal;
}

AllanOptions curve_options_of(const Settings& settings, const EvenSignal& signal) {
  AllanOptions options{settings.number("points_per_decade"), settings.number("confidence"),
                       settings.number("longest_fraction")};
  options.factors = asked_factors(settings, signal.rate, signal.values.size());
  options.remove_bias = settings.word("total_bias") == "remove";
  options.subtract_mean_rate = settings.word("mean_rate") == "subtract";
  return options;
}

std::vector<std::size_t> asked_factors(const Settings& settings, double rate, std::size_t samples) {
  const std::string& taus = settings.word("taus");
  std::vector<std::size_t> factors;
  if (taus == "log" || taus == "all") return factors;
  const double most = settings.number("longest_fraction") * static_cast<double>(samples);
  if (taus == "octave" || taus == "decade") {
    const auto add = [&](double factor) {
      if (factor <= std::max(1.0, most)) factors.push_back(static_cast<std::size_t>(factor));
    };
    for (double step = 1.0; step <= std::max(1.0, most); step *= taus == "octave" ? 2.0 : 10.0)
      for (const double part : {1.0, 2.0, 4.0})
        if (taus == "decade" || part == 1.0) add(step * part);
    return factors;
  }
  for (const auto& word : listed_words(taus)) {
    const double tau = time_of_word(word), factor = std::round(tau * rate);
    if (factor < 1.0 || factor > 0.5 * static_cast<double>(samples))
      throw Error(Error::Kind::bad_data,
                  say("taus: {} must lie between the sampling interval {} and half of the record, {}", Name{word},
                      Name{say_seconds(1.0 / rate)}, Name{say_seconds(0.5 * static_cast<double>(samples) / rate)}));
    factors.push_back(static_cast<std::size_t>(factor));
  }
  std::ranges::sort(factors);
  const auto repeated = std::ranges::unique(factors);
  factors.erase(repeated.begin(), repeated.end());
  return factors;
}

}  // namespace tumble::allan_noise
