// The lock-in equation of the ring laser gyro: how fast, how exact, and what it says of the formulas (4.26) and (4.27).
// Prints bench/results/lock_in.md. usage: bench_lock_in [a number > 1 makes the random walks that much longer]

#include "tumble/models/lock_in.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include "tumble/models/lock_zones.hpp"
#include "tumble/models/ring_laser_gyro/testing/beat_reference.hpp"
#include "tumble/units/unit.hpp"

namespace {

using namespace tumble;

constexpr double K = 91237.4003;  // 632.8 nm, triangle of 10 cm

double deg(double value) { return si(value, "deg/s"); }

std::string machine() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

struct Setting {
  double lock_in, dither, frequency, noise, input;  // deg/s, deg/s, Hz, 1, deg/s
};

LockIn lock_of(const Setting& s) { return {K, deg(s.lock_in)}; }
Dither dither_of(const Setting& s) { return {deg(s.dither), s.frequency, s.noise}; }

/// Error of the mean output rate relative to W_L over `periods` dither periods, the first 20 apart, and over the worst
/// of the tenths of that time; steps a second of processor time.
struct Measured {
  double x, steps_a_period, whole, tenth, speed;
};

Measured measure(const Setting& s) {
  const LockIn lock = lock_of(s);
  const Dither dither = dither_of(s);
  const RandomStream random(7);
  const int periods = 400, parts = 10;
  testing::BeatReference reference(lock, dither, deg(s.input), random, 20000);
  BeatPhase beat(lock, dither, 0.0, random);
  const double period = 1.0 / s.frequency, part = periods / parts * period;
  const auto error = [&](int count) {
    double ours = 0.0, theirs = 0.0;
    const double rate = deg(s.input);
    for (int i = 0; i < count; ++i) {
      beat.advance(period, std::span(&rate, 1), std::span(&ours, 1));
      reference.half_cycle();
      theirs = reference.half_cycle();
    }
    return (ours - theirs) / (K * lock.rate);
  };
  Measured m{phase_excursion(lock, dither), 0.0, 0.0, 0.0, 0.0};
  double before = error(20);
  const double first = before;
  for (int i = 0; i < parts; ++i) {
    const double now = error(periods / parts);
    m.tenth = std::max(m.tenth, std::abs(now - before) / part);
    before = now;
  }
  m.whole = std::abs(before - first) / (part * parts);

  BeatPhase timed(lock, dither, 0.0, random);
  const std::vector<double> rates(static_cast<std::size_t>(4e7 * period / 1.0) + 100, deg(s.input));
  std::vector<double> out(rates.size());
  const std::clock_t begin = std::clock();
  timed.advance(period, rates, out);
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  m.speed = static_cast<double>(timed.steps()) / seconds;
  m.steps_a_period = static_cast<double>(timed.steps()) / static_cast<double>(rates.size());
  return m;
}

void speed_and_error() {
  fmt::print(
      "## Speed and error\n\nError of the mean output rate relative to W_L against Runge-Kutta steps of the same "
      "equation, 40 000 a dither period: over 400 periods, and in the worst of ten parts of 40 periods. Speed: "
      "steps that resolve the dither, one thread, processor time.\n\n"
      "| W_L [deg/s] | W_A [deg/s] | f_D [Hz] | noise | w_i [deg/s] | K W_L/f_D | x [rad] | steps a period | "
      "error, 400 periods | error, 40 periods | steps/s |\n|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  const Setting settings[]{{0.1, 100, 400, 0, 0.01},  {0.1, 100, 400, 0, 0.37},    {0.1, 100, 400, 0, 20},
                           {0.25, 100, 400, 0, 0.02}, {0.1, 100, 400, 0.02, 0.01}, {0.1, 200, 400, 0.02, 0.2},
                           {0.05, 30, 421, 0.05, 0},  {0.1, 3, 400, 0, 0.01},      {0.02, 0.5, 400, 0, 0.01}};
  for (const auto& s : settings) {
    const Measured m = measure(s);
    fmt::print("| {} | {} | {} | {} | {} | {:.2f} | {:.0f} | {:.0f} | {:.1e} | {:.1e} | {:.2g} |\n", s.lock_in,
               s.dither, s.frequency, s.noise, s.input, K * deg(s.lock_in) / s.frequency, m.x, m.steps_a_period,
               m.whole, m.tenth, m.speed);
  }
}

/// Root of the mean square of the angle gained over 20 periods less its expectation, as a random walk; `count` pieces.
void random_walks(double longer) {
  const auto count = static_cast<std::size_t>(20000 * longer);
  fmt::print(
      "\n## Random walk from noisy dither, (4.27)\n\n{} pieces of 20 dither periods each: the ratio is known to "
      "{:.2f} % (1 sigma).\n\n| W_L [deg/s] | W_A [deg/s] | f_D [Hz] | noise of a turn-around [rad] | w_i [deg/s] "
      "| K W_L/f_D | N by (4.27) [deg/sqrt(h)] | simulated/formula | deviation [sigma] |\n"
      "|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      count, 100.0 / std::sqrt(2.0 * static_cast<double>(count)));
  const Setting settings[]{{0.1, 100, 400, 0.03, 0},    {0.1, 100, 400, 0.03, 0.17}, {0.03, 100, 401, 0.03, 0.01},
                           {0.05, 60, 382, 0.05, 0.05}, {0.1, 200, 421, 0.02, 0},    {0.2, 150, 400, 0.02, 0.01}};
  std::uint64_t seed = 0;
  for (const auto& s : settings) {
    const LockIn lock = lock_of(s);
    const Dither dither = dither_of(s);
    const double step = 20.0 / s.frequency;
    BeatPhase beat(lock, dither, 0.3, RandomStream(11).split(seed++));
    // Pieces begin at the highest dither rate, so that none of them cuts a turn-around in two.
    double begin = 0.0;
    beat.advance(0.25 / s.frequency, std::vector<double>{deg(s.input)}, std::span(&begin, 1));
    const std::vector<double> rate(count + 1, deg(s.input));
    std::vector<double> fringes(rate.size());
    beat.advance(step, rate, fringes);
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 1; i < fringes.size(); ++i) {
      const double gained = (fringes[i] - fringes[i - 1]) / K - deg(s.input) * step;
      sum += gained;
      squares += gained * gained;
    }
    const auto n = static_cast<double>(count);
    const double walk = std::sqrt((squares - sum * sum / n) / (n - 1.0) / step);
    const double formula = angle_random_walk_from_lock_in(lock, dither), ratio = walk / formula;
    fmt::print("| {} | {} | {} | {:.1f} | {} | {:.2f} | {:.3e} | {:.4f} | {:+.1f} |\n", s.lock_in, s.dither,
               s.frequency, s.noise * phase_excursion(lock, dither), s.input, K * lock.rate / s.frequency,
               Unit::parse("deg/sqrt(h)").from_si(formula), ratio, (ratio - 1.0) * std::sqrt(2.0 * n));
  }
}

/// Where the output leaves the zone, by bisection; direction +1 or -1.
double edge(const LockIn& lock, const Dither& dither, const LockZone& zone, double direction) {
  double inside = 0.0, outside = 3.0 * zone.half_width;
  for (int i = 0; i < 48; ++i) {
    const double middle = 0.5 * (inside + outside);
    const double output = mean_output_rate(lock, dither, zone.centre - zone.pull + direction * middle);
    (std::abs(output - zone.centre) < 1e-9 * zone.half_width ? inside : outside) = middle;
  }
  return zone.centre - zone.pull + direction * inside;
}

void lock_zones() {
  fmt::print(
      "\n## Lock zones, (4.26)\n\nFrom the rotation number of one dither period. Half width beside W_L |J_n(x)|, "
      "centre beside w_n - p, and the output at 1.1, 1.5 and 3 half widths off the centre beside "
      "w_n + sign(d) sqrt(d^2 - W_n^2) with and without the pull p; all in % of W_n.\n\n"
      "| x [rad] | n | K W_L/f_D | J_n | half width | centre | output, worst of six | without p |\n"
      "|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  struct Case {
    double x, ratio;
    int n;
  };
  for (const Case& c :
       {Case{10, 0.05, 0}, Case{10, 0.05, 1}, Case{30, 0.05, 0}, Case{100, 0.05, 0}, Case{100, 0.05, 2},
        Case{398, 0.05, 0}, Case{398, 0.05, 3}, Case{398, 0.398, 0}, Case{3, 0.05, 5}, Case{3, 0.01, 5}}) {
    const double frequency = 400.0;
    const LockIn lock{K, c.ratio * frequency / K};
    const Dither dither{c.x * frequency / K, frequency, 0.0};
    const LockZone zone = lock_zone(lock, dither, c.n);
    const double low = edge(lock, dither, zone, -1.0), high = edge(lock, dither, zone, 1.0);
    double worst = 0.0, without = 0.0;
    for (const double off : {-3.0, -1.5, -1.1, 1.1, 1.5, 3.0}) {
      const double rate = zone.centre - zone.pull + off * zone.half_width;
      const double output = mean_output_rate(lock, dither, rate), d = rate - zone.centre;
      worst = std::max(worst, std::abs(output - output_near_zone(lock, dither, c.n, rate)) / zone.half_width);
      const double square = (d - zone.half_width) * (d + zone.half_width);
      const double plain = zone.centre + (square > 0.0 ? std::copysign(std::sqrt(square), d) : 0.0);
      without = std::max(without, std::abs(output - plain) / zone.half_width);
    }
    fmt::print("| {:.0f} | {} | {} | {:.4f} | {:+.2f} % | {:+.2f} % | {:.2f} % | {:.2f} % |\n", c.x, c.n, c.ratio,
               zone.half_width / lock.rate, 100.0 * ((high - low) / 2.0 / zone.half_width - 1.0),
               100.0 * ((high + low) / 2.0 - zone.centre + zone.pull) / zone.half_width, 100.0 * worst,
               100.0 * without);
  }
}

}  // namespace

int main(int count, char** words) {
  fmt::print(
      "# Lock-in of the ring laser gyro\n\nMachine: {}, one core. Compiler: g++ {}. K = 91237.4 fringe/rad. Made by "
      "`bench/lock_in.cpp`.\n\n",
      machine(), __VERSION__);
  speed_and_error();
  random_walks(count > 1 ? std::stod(words[1]) : 1.0);
  lock_zones();
}
