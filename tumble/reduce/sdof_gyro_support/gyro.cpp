#include "tumble/reduce/sdof_gyro_support/gyro.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/trial_plan.hpp"
#include "tumble/units/error.hpp"

namespace tumble::sdof_gyro_support {

Role gyro_role() { return {"gyro", "", true, "output of the gyro: a rate, or the torquer current"}; }

std::vector<Option> reading_options() {
  using Type = Option::Type;
  return {{"torquer_scale_factor",
           Type::quantity,
           "deg/h/mA",
           "",
           {},
           "S_g: rate for a unit of torquer current, needed where the gyro's output is a current"},
          {"torquer_scale_factor_sd", Type::quantity, "ppm", "0 ppm", {}, "its relative standard uncertainty"}};
}

const Channel* channel(const Evidence& evidence) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  return &require_channel(evidence, evidence.recordings.front(), "gyro");
}

void set_reading(const Settings& settings, const Channel* channel, linear::Problem& problem) {
  problem.role = "gyro";
  problem.input = [](const Felt& felt) { return felt.rate.x; };
  const double sd = settings.number("torquer_scale_factor_sd");
  if (sd < 0.0) throw Error(Error::Kind::bad_input, "[settings] torquer_scale_factor_sd must not be negative");
  if (sd > 0.0)
    problem.reading_errors.push_back({"torquer scale factor", sd, [](const Felt&, double rate) { return rate; }});
  if (!channel || channel->unit.dimension() == Unit::parse("deg/h").dimension()) return;
  if (channel->unit.dimension() != Unit::parse("mA").dimension())
    throw Error(Error::Kind::bad_data, fmt::format("channel '{}' is in {}: the gyro's output must be a rate (deg/h) or "
                                                   "a torquer current (mA)",
                                                   channel->name, channel->unit.text()));
  if (!settings.has("torquer_scale_factor") || settings.number("torquer_scale_factor") == 0.0)
    throw Error(Error::Kind::bad_input,
                fmt::format("channel '{}' is a current ({}): [settings] torquer_scale_factor = \"510 deg/h/mA\" or the "
                            "like must say what rate it balances",
                            channel->name, channel->unit.text()));
  problem.scale = settings.number("torquer_scale_factor");
}

std::vector<Term> terms(const std::vector<std::string>& names) {
  return linear::terms_of("sdof_gyro", defaults(find_model("sdof_gyro").constants()), names);
}

void add_repeats(const linear::Solution& solution, Estimate& estimate) {
  const auto same = [](const linear::SegmentSummary& a, const linear::SegmentSummary& b) {
    return a.steady && b.steady && norm(a.felt.specific_force - b.felt.specific_force) < 1e-4 &&
           norm(a.felt.rate - b.felt.rate) < 1e-9;
  };
  const Unit rate = Unit::parse("deg/h");
  Table table{"repeats", "residuals of positions that were taken more than once", {}, {}};
  table.columns = {{"label", Unit()}, {"times", Unit()}, {"sd", rate}, {"noise_sd", rate}};
  std::vector<bool> done(solution.segments.size(), false);
  double squares = 0.0, freedom = 0.0;
  for (std::size_t a = 0; a < solution.segments.size(); ++a) {
    double count = 0.0, sum = 0.0, sum_squares = 0.0, noise = 0.0;
    for (std::size_t b = a; b < solution.segments.size(); ++b) {
      const auto& segment = solution.segments[b];
      if (done[b] || std::isnan(segment.measured) || !same(solution.segments[a], segment)) continue;
      done[b] = true;
      const double residual = segment.measured - segment.predicted;
      count += 1.0;
      sum += residual;
      sum_squares += residual * residual;
      noise += segment.sd * segment.sd;
    }
    if (count < 2.0) continue;
    const double about_mean = std::max(0.0, sum_squares - sum * sum / count);
    squares += about_mean;
    freedom += count - 1.0;
    table.rows.push_back(
        {solution.segments[a].label, count, std::sqrt(about_mean / (count - 1.0)), std::sqrt(noise / count)});
  }
  if (freedom == 0.0) return;
  estimate.findings.push_back({Finding::Severity::info,
                               fmt::format("repeatability of positions: {:.3g} deg/h ({} repeats)",
                                           rate.from_si(std::sqrt(squares / freedom)), freedom),
                               ""});
  estimate.tables.push_back(std::move(table));
}

Plan trial_plan(const std::string& method, const std::vector<Option>& options, const std::string& rig, double rate) {
  Plan plan = trial_plan(method, options, "sdof_gyro", rig, rate);
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  const char* first = "deg/h/g";
  const char* second = "deg/h/g^2";
  set("D_F", 1.8, "deg/h");
  set("D_I", 2.5, first);
  set("D_O", 0.01, first);
  set("D_S", -1.2, first);
  set("D_IO", 0.03, second);
  set("D_OS", -0.02, second);
  set("D_IS", 0.08, second);
  set("D_II", 0.05, second);
  set("D_SS", -0.04, second);
  set("angle_random_walk", 0.002, "deg/sqrt(h)");
  set("bias_instability", 0.01, "deg/h");
  return plan;
}

std::vector<Position> cube_positions() {
  const auto degrees = [](const char* label, double outer, double inner) {
    return Position{label, si(outer, "deg"), si(inner, "deg")};
  };
  // f = (sin outer sin inner, sin outer cos inner, cos outer) g in the axes I, O, S.
  const double corner = 54.735610317245346;
  return {degrees("I up", 90, 90),
          degrees("O S", 45, 0),
          degrees("-O", 90, 180),
          degrees("I O -S", 180 - corner, 45),
          degrees("-I S", 45, 270),
          degrees("S up", 0, 0),
          degrees("I -O", 90, 135),
          degrees("-O -S", 135, 180),
          degrees("-I -O S", corner, 225),
          degrees("O up", 90, 0),
          degrees("I S", 45, 90),
          degrees("-I -S", 135, 270),
          degrees("-I O S", corner, 315),
          degrees("-I down", 90, 270),
          degrees("I O", 90, 45),
          degrees("-O S", 45, 180),
          degrees("I -O -S", 180 - corner, 135),
          degrees("S down", 180, 0),
          degrees("-I O", 90, 315),
          degrees("I -S", 135, 90),
          degrees("I O S", corner, 45),
          degrees("-I -O", 90, 225),
          degrees("O -S", 135, 0),
          degrees("-I O -S", 180 - corner, 315),
          degrees("I -O S", corner, 135),
          degrees("-I -O -S", 180 - corner, 225)};
}

Segment at(const Position& position, double duration) {
  return {position.label,
          duration,
          1,
          {{"outer", {.kind = Motion::Kind::hold, .value = position.outer}},
           {"inner", {.kind = Motion::Kind::hold, .value = position.inner}}}};
}

}  // namespace tumble::sdof_gyro_support
