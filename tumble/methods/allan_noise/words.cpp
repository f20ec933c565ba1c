#include "tumble/methods/allan_noise/words.hpp"

#include <cmath>

namespace tumble::allan_noise {

std::string rate_unit(QuantityKind kind) {
  if (kind == QuantityKind::other) return "1";
  return kind == QuantityKind::angular_rate ? "deg/h" : "ug";
}

std::string ramp_unit(QuantityKind kind) { return kind == QuantityKind::other ? "1/s" : rate_unit(kind) + "/h"; }

namespace {

/// Of a fractional frequency.
TermWords clock_words(NoiseTerm term) {
  switch (term) {
    case NoiseTerm::quantization:
      return {"white_phase_noise", "Q", "s", "white noise of the time error"};
    case NoiseTerm::white:
      return {"white_frequency_noise", "N", "sqrt(s)", "white noise of the fractional frequency"};
    case NoiseTerm::flicker:
      return {"flicker_frequency_noise", "B", "1",
              "flicker of the frequency; the flat part of the deviation is 0.664 B"};
    case NoiseTerm::random_walk:
      return {"random_walk_frequency_noise", "K", "1/sqrt(s)", "random walk of the fractional frequency"};
    case NoiseTerm::markov:
      return {"markov_sd", "sigma_c", "1", "first-order Gauss-Markov frequency"};
  }
  return {};
}

}  // namespace

TermWords words(NoiseTerm term, QuantityKind kind) {
  if (kind == QuantityKind::other) return clock_words(term);
  const bool rate = kind == QuantityKind::angular_rate;
  switch (term) {
    case NoiseTerm::quantization:
      return {"quantization_noise", "Q", rate ? "arcsec" : "mm/s",
              rate ? "white noise of the angle" : "white noise of the velocity"};
    case NoiseTerm::white:
      return {rate ? "angle_random_walk" : "velocity_random_walk", "N", rate ? "deg/sqrt(h)" : "(m/s)/sqrt(h)",
              rate ? "white noise of the rate" : "white noise of the specific force"};
    case NoiseTerm::flicker:
      return {"bias_instability", "B", rate_unit(kind),
              "flicker of the bias; the flat part of the deviation is 0.664 B"};
    case NoiseTerm::random_walk:
      return {rate ? "rate_random_walk" : "acceleration_random_walk", "K", rate ? "deg/h/sqrt(h)" : "ug/sqrt(h)",
              "random walk of the bias"};
    case NoiseTerm::markov:
      return {"markov_sd", "sigma_c", rate_unit(kind), "first-order Gauss-Markov bias"};
  }
  return {};
}

double coefficient(NoiseTerm term, double squared, double rate) {
  switch (term) {
    case NoiseTerm::quantization:
      return std::sqrt(squared) / rate;
    case NoiseTerm::white:
      return std::sqrt(squared / rate);
    case NoiseTerm::random_walk:
      return std::sqrt(squared * rate);
    case NoiseTerm::flicker:
    case NoiseTerm::markov:
      break;
  }
  return std::sqrt(squared);
}

}  // namespace tumble::allan_noise
