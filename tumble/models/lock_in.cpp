#include "tumble/models/lock_in.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/circle.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

/// Steps a second such that the phase turns by less than 2 rad a step, the coupling moves it by less than 0.05 rad,
/// and 256 steps or more make a period of the dither.
double steps_per_second(const LockIn& lock_in, const Dither& dither, double input_rate) {
  const double fastest = dither.rate * (1.0 + 4.0 * dither.noise) + std::abs(input_rate);
  return std::max({256.0 * dither.frequency, 2.0 * pi * lock_in.scale_factor * fastest / 2.0,
                   2.0 * pi * lock_in.scale_factor * lock_in.rate / 0.05});
}

/// The coupling over h at the known phase whose cosine and sine are given: u += ... of w' = e/2 e^{-i phi} conj(w).
inline void couple(double cosh, double sinh, double cosine, double sine, double& real, double& imaginary) {
  const double c = sinh * cosine, s = sinh * sine, r = real;
  real = (cosh + c) * r - s * imaginary;
  imaginary = (cosh - c) * imaginary - s * r;
}

/// By how much one step of h turns the known phase less than exactly, which takes off the error of splitting at second
/// order in e: (a h/2) cot(a h/2) = 1 - (a h)^2/12 - (a h)^4/720 - ... in place of 1. The dither takes the first term,
/// the input the second too, as its mean over the dither.
double shrink_of_dither(double coupling) { return 1.0 - coupling * coupling / 24.0; }
double shrink_of_input(double coupling, double input, double dither) {
  return 1.0 - coupling * coupling / 24.0 * (1.0 + (input * input + 1.5 * dither * dither) / 60.0);
}

/// Parts of a step for white noise of the input, so many that the phase turns by less than 0.8 rad W/W_L in each. It
/// turns at 2 pi K sqrt|W^2 - W_L^2|, and at the edge of the dead band as fast as within the width over which the noise
/// rounds it.
std::size_t parts_of(double step, double rate, const LockIn& lock_in, double white) {
  constexpr double turn = 0.8;  // [rad]
  const double diffusion = pi * lock_in.scale_factor * white;
  const double width = std::cbrt(lock_in.rate * diffusion * diffusion);
  const double square = std::abs((rate - lock_in.rate) * (rate + lock_in.rate)) + 2.0 * lock_in.rate * width;
  const double share = lock_in.rate / std::max(lock_in.rate, std::abs(rate));
  return static_cast<std::size_t>(std::ceil(2.0 * pi * lock_in.scale_factor * std::sqrt(square) * share * step / turn));
}

}  // namespace

BeatPhase::BeatPhase(const LockIn& lock_in, const Dither& dither, double start, const RandomStream& random,
                     double white)
    : lock_in_(lock_in), dither_(dither), random_(random), white_(white), slow_(start) {
  const double swing = dither.rate > 0.0 ? lock_in.scale_factor * dither.rate / (2.0 * pi * dither.frequency) : 0.0;
  if (dither.noise > 0.0) {
    last_turn_ = swing * dither.noise * random_.normal(0);
    next_turn_ = swing * dither.noise * random_.normal(1);
  }
  offset_ = 0.5 * (next_turn_ - last_turn_);
  swing_ = -swing - 0.5 * (next_turn_ + last_turn_);
  const CirclePoint point = on_circle(0.5 * slow_);
  real_ = point.cosine;
  imaginary_ = point.sine;
}

void BeatPhase::next_half_cycle() {
  ++half_cycle_;
  half_cycles_ -= 1.0;
  const double sign = half_cycle_ % 2 == 0 ? 1.0 : -1.0;
  const double swing = lock_in_.scale_factor * dither_.rate / (2.0 * pi * dither_.frequency);
  last_turn_ = next_turn_;
  next_turn_ = dither_.noise > 0.0 ? swing * dither_.noise * random_.normal(half_cycle_ + 1) : 0.0;
  offset_ = sign * 0.5 * (next_turn_ - last_turn_);
  swing_ = -sign * (swing + 0.5 * (next_turn_ + last_turn_));
}

double BeatPhase::dither_fringes() const {
  return dither_.rate > 0.0 ? offset_ + swing_ * on_circle(0.5 * half_cycles_).cosine : 0.0;
}

void BeatPhase::choose_table(double h) {
  const double coupling = 2.0 * pi * lock_in_.scale_factor * lock_in_.rate * h;
  table_h_ = h;
  cosh_ = std::cosh(0.5 * coupling);
  sinh_ = std::sinh(0.5 * coupling);
  shrink_ = shrink_of_dither(coupling);
  // over one batch the slow part moves by less than 3 rad: its angle is followed without ambiguity
  longest_ = coupling * static_cast<double>(batch) < 3.0 ? batch : static_cast<std::size_t>(3.0 / coupling);
  for (std::size_t j = 0; j < batch; ++j) {
    const CirclePoint point = on_circle(dither_.frequency * h * (static_cast<double>(j) + 0.5));
    table_cosine_[j] = point.cosine;
    table_sine_[j] = point.sine;
  }
}

/// Up to `most` steps of one half cycle; returns how many.
std::size_t BeatPhase::kick(double h, double turns_a_step, std::size_t most) {
  const double half_cycles_a_step = 2.0 * dither_.frequency * h;
  if (half_cycles_ + 0.5 * half_cycles_a_step >= 1.0) next_half_cycle();
  const auto here = static_cast<std::size_t>(std::ceil((1.0 - half_cycles_) / half_cycles_a_step - 0.5));
  const std::size_t count = std::min({most, longest_, std::max<std::size_t>(here, 1)});

  double cosine[batch], sine[batch];
  const CirclePoint now = on_circle(0.5 * half_cycles_);
  const double along = shrink_ * swing_ * now.cosine, across = shrink_ * swing_ * now.sine;
  const double first = input_ + shrink_ * offset_;
  double index = 0.5;
  for (std::size_t j = 0; j < count; ++j) {
    const CirclePoint point =
        on_circle(first + turns_a_step * index + (along * table_cosine_[j] - across * table_sine_[j]));
    index += 1.0;
    cosine[j] = point.cosine;
    sine[j] = point.sine;
  }
  double real = real_, imaginary = imaginary_;
  for (std::size_t j = 0; j < count; ++j) couple(cosh_, sinh_, cosine[j], sine[j], real, imaginary);
  slow_ += std::atan2(real_ * imaginary - imaginary_ * real, real_ * real + imaginary_ * imaginary) / pi;
  const double norm = 1.0 / std::sqrt(real * real + imaginary * imaginary);
  real_ = real * norm;
  imaginary_ = imaginary * norm;
  input_ += turns_a_step * static_cast<double>(count);
  half_cycles_ += half_cycles_a_step * static_cast<double>(count);
  steps_ += count;
  return count;
}

void BeatPhase::advance_dithered(double step, double rate) {
  const double needed = std::ceil(step * steps_per_second(lock_in_, dither_, rate));
  auto left = static_cast<std::size_t>(needed);
  const double h = step / needed;
  if (h != table_h_) choose_table(h);
  const double radians = 2.0 * pi * lock_in_.scale_factor * h;
  const double turns_a_step = lock_in_.scale_factor * rate * h *
                              shrink_of_input(radians * lock_in_.rate, radians * rate, radians * dither_.rate);
  while (left > 0) left -= kick(h, turns_a_step, left);
}

/// Exact for a constant rate: u' = G u with G = [e, -a; a, -e]/2, G^2 = (e^2 - a^2)/4.
void BeatPhase::advance_free(double step, double rate) {
  const double a = 2.0 * pi * lock_in_.scale_factor * rate, e = 2.0 * pi * lock_in_.scale_factor * lock_in_.rate;
  const double square = 0.25 * (e - a) * (e + a), root = std::sqrt(std::abs(square)), turn = root * step;
  double even = 1.0, odd = step, half_turns = 0.0;  // exp(G step) = even + odd G, up to a positive factor
  if (square > 0.0) {
    const double decay = std::exp(-2.0 * turn);
    even = 0.5 * (1.0 + decay);
    odd = turn > 1e-8 ? 0.5 * (1.0 - decay) / root : step;
  } else if (turn > 0.0) {
    half_turns = std::floor(turn / pi);
    const CirclePoint point = on_circle(turn / (2.0 * pi) - 0.5 * half_turns);
    even = point.cosine;
    odd = turn > 1e-8 ? point.sine / root : step;
  }
  const double real = even * real_ + 0.5 * odd * (e * real_ - a * imaginary_);
  const double imaginary = even * imaginary_ + 0.5 * odd * (a * real_ - e * imaginary_);
  double angle = std::atan2(real_ * imaginary - imaginary_ * real, real_ * real + imaginary_ * imaginary);
  if (square < 0.0) {  // less than half a turn, in the sense of a
    if (a > 0.0 && angle < 0.0) angle = angle < -0.5 * pi ? angle + 2.0 * pi : 0.0;
    if (a < 0.0 && angle > 0.0) angle = angle > 0.5 * pi ? angle - 2.0 * pi : 0.0;
  }
  slow_ += angle / pi + std::copysign(half_turns, a);
  const double norm = 1.0 / std::sqrt(real * real + imaginary * imaginary);
  const double sign = half_turns - 2.0 * std::floor(0.5 * half_turns) > 0.5 ? -norm : norm;
  real_ = real * sign;
  imaginary_ = imaginary * sign;
}

/// Half a part, an impulse with the angle of its noise, the other half (Strang 1968). The angles together are
/// subtracted from the impulses, since `rate` contains them.
void BeatPhase::advance_noisy(double step, double rate) {
  const std::size_t parts = parts_of(step, rate, lock_in_, white_);
  if (parts <= 1) return advance_free(step, rate);
  const double part = step / static_cast<double>(parts), sd = lock_in_.scale_factor * std::sqrt(white_ * part);
  noise_.resize(parts);
  random_.normal(drawn_, noise_);
  drawn_ += parts + parts % 2;
  const double mean = std::accumulate(noise_.begin(), noise_.end(), 0.0) / static_cast<double>(parts);
  advance_free(0.5 * part, rate);
  for (std::size_t i = 0; i < parts; ++i) {
    const double turns = sd * (noise_[i] - mean);
    const CirclePoint half = on_circle(0.5 * turns);
    slow_ += turns;
    const double real = real_;
    real_ = half.cosine * real - half.sine * imaginary_;
    imaginary_ = half.cosine * imaginary_ + half.sine * real;
    advance_free(i + 1 < parts ? part : 0.5 * part, rate);
  }
}

void BeatPhase::advance(double step, std::span<const double> rate, std::span<double> fringes) {
  for (std::size_t i = 0; i < rate.size(); ++i) {
    if (dither_.rate > 0.0) {
      advance_dithered(step, rate[i]);
    } else if (white_ > 0.0 && lock_in_.rate > 0.0) {
      advance_noisy(step, rate[i]);
    } else {
      advance_free(step, rate[i]);
    }
    const double whole = std::round(input_);
    input_ -= whole;
    turns_ += whole;
    fringes[i] = this->fringes();
  }
}

double mean_output_rate(const LockIn& lock_in, const Dither& dither, double input_rate) {
  const double K = lock_in.scale_factor;
  if (!(dither.rate > 0.0)) {
    const double square = (input_rate - lock_in.rate) * (input_rate + lock_in.rate);
    return square > 0.0 ? std::copysign(std::sqrt(square), input_rate) : 0.0;
  }
  const double period = 1.0 / dither.frequency;
  const double steps = std::ceil(period * steps_per_second(lock_in, {dither.rate, dither.frequency, 0.0}, input_rate));
  const double h = period / steps, radians = 2.0 * pi * K * h, coupling = radians * lock_in.rate;
  const double cosh = std::cosh(0.5 * coupling), sinh = std::sinh(0.5 * coupling);
  const double swing = shrink_of_dither(coupling) * K * dither.rate / (2.0 * pi * dither.frequency);
  const double turns = K * input_rate * h * shrink_of_input(coupling, radians * input_rate, radians * dither.rate);
  double first[2]{1.0, 0.0}, second[2]{0.0, 1.0}, turned = 0.0;  // both columns; angle of the first [rad]
  for (double j = 0.5; j < steps; j += 1.0) {
    const CirclePoint at = on_circle(turns * j - swing * on_circle(j / steps).cosine);
    const double before[2]{first[0], first[1]};
    couple(cosh, sinh, at.cosine, at.sine, first[0], first[1]);
    couple(cosh, sinh, at.cosine, at.sine, second[0], second[1]);
    turned += std::atan2(before[0] * first[1] - before[1] * first[0], before[0] * first[0] + before[1] * first[1]);
  }
  const double half = pi * turns * steps;  // half of the known phase of a period
  const CirclePoint back = on_circle(half / (2.0 * pi));
  const double half_trace = 0.5 * (back.cosine * (first[0] + second[1]) - back.sine * (first[1] - second[0]));
  const double angle = half + turned, sign_even = half_trace > 0.0 ? 1.0 : -1.0;
  double turn;  // of u, over a period: k pi in a lock zone, else between floor(angle/pi) pi and the next
  if (std::abs(half_trace) >= 1.0) {
    turn = 2.0 * pi * std::round((angle - (sign_even > 0.0 ? 0.0 : pi)) / (2.0 * pi)) + (sign_even > 0.0 ? 0.0 : pi);
  } else {
    const double k = std::floor(angle / pi);
    const double parity = k - 2.0 * std::floor(0.5 * k) > 0.5 ? -1.0 : 1.0;
    turn = k * pi + std::acos(parity * half_trace);
  }
  return turn / (pi * K * period);
}

}  // namespace tumble
