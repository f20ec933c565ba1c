#include "tumble/reduce/sdof_gyro_support/gyro.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/units/error.hpp"

namespace tumble::sdof_gyro_support {

std::vector<Role> roles() { return {{"gyro", "", true, "output of the gyro: a rate, or the torquer current"}}; }

std::vector<Option> options(const std::string& settling, const std::string& averaging) {
  std::vector<Option> options{
      quantity("torquer_scale_factor", "deg/h/mA")
          .says("S_g: rate for a unit of torquer current, needed where the gyro's output is a current"),
      quantity("torquer_scale_factor_sd", "ppm")
          .at_least(0)
          .otherwise("0 ppm")
          .says("relative standard uncertainty of torquer_scale_factor")};
  for (auto& option : linear::options(settling, averaging)) options.push_back(std::move(option));
  options.push_back(linear::bias_instability_option("deg/h"));
  return options;
}

namespace {

/// Rate [rad/s] for one SI unit of the channel.
double scale_of(const Settings& settings, const Channel& channel) {
  const auto is = [&](const char* unit) { return channel.unit.dimension() == Unit::parse(unit).dimension(); };
  if (is("deg/h")) return 1.0;
  if (!is("mA"))
    throw Error(Error::Kind::bad_data, say("channel '{}' is in {}: the gyro's output must be a rate (deg/h) or "
                                           "a torquer current (mA)",
                                           channel.name, Name{channel.unit.text()}));
  if (!settings.has("torquer_scale_factor") || settings.number("torquer_scale_factor") == 0.0)
    throw Error(Error::Kind::bad_input,
                say("channel '{}' is a current ({}): [settings] torquer_scale_factor = \"510 deg/h/mA\" or the "
                    "like must say what rate it balances",
                    channel.name, Name{channel.unit.text()}));
  return settings.number("torquer_scale_factor");
}

}  // namespace

linear::Problem problem_of(const Settings& settings, const Channel* channel) {
  linear::Problem problem;
  problem.role = "gyro";
  problem.input = Input::rate_x;
  linear::set_options(settings, problem);
  if (const double sd = settings.number("torquer_scale_factor_sd"); sd > 0.0)
    problem.reading_errors.push_back({"torquer scale factor", sd, [](const Felt&, double rate) { return rate; }});
  if (channel) problem.scale = scale_of(settings, *channel);
  return problem;
}

std::vector<std::string> first_order_terms() { return {"D_F", "D_I", "D_O", "D_S"}; }

std::vector<std::string> drift_terms() {
  return {"D_F", "D_I", "D_O", "D_S", "D_IO", "D_OS", "D_IS", "D_II", "D_OO", "D_SS"};
}

std::vector<Term> terms(const std::vector<std::string>& names) {
  return linear::terms_of("sdof_gyro", defaults(find_model("sdof_gyro").constants()), names);
}

namespace {

/// Residuals [rad/s] of one position.
struct Repeats {
  std::string label;
  double count = 0.0, sum = 0.0, squares = 0.0, noise = 0.0;

  void add(const linear::SegmentSummary& segment) {
    const double residual = segment.measured - segment.predicted;
    count += 1.0;
    sum += residual;
    squares += residual * residual;
    noise += segment.sd * segment.sd;
  }
  double about_mean() const { return std::max(0.0, squares - sum * sum / count); }
};

bool is_same_position(const linear::SegmentSummary& a, const linear::SegmentSummary& b) {
  return a.steady && b.steady && linear::is_same_input(a.felt, b.felt);
}

}  // namespace

void add_repeats(const linear::Solution& solution, Estimate& estimate) {
  const Unit rate = Unit::parse("deg/h");
  std::vector<Repeats> repeated;
  std::vector<bool> done(solution.segments.size(), false);
  double squares = 0.0;
  std::size_t freedom = 0;
  for (std::size_t a = 0; a < solution.segments.size(); ++a) {
    Repeats repeats{solution.segments[a].label};
    for (std::size_t b = a; b < solution.segments.size(); ++b) {
      const auto& segment = solution.segments[b];
      if (done[b] || std::isnan(segment.measured) || !is_same_position(solution.segments[a], segment)) continue;
      done[b] = true;
      repeats.add(segment);
    }
    if (repeats.count < 2.0) continue;
    squares += repeats.about_mean();
    freedom += static_cast<std::size_t>(repeats.count) - 1;
    repeated.push_back(repeats);
  }
  if (freedom == 0) return;
  const double sd = std::sqrt(squares / static_cast<double>(freedom));
  estimate.findings.push_back(
      {Finding::Severity::info, "repeatability_of_positions", {{"repeatability", sd, rate}, {"repeats", freedom}}});
  estimate.tables.push_back(
      tabulate("repeats", "residuals of positions that were taken more than once", repeated,
               {{"label", &Repeats::label},
                {"times", &Repeats::count},
                {"sd", rate, [](const Repeats& r) { return std::sqrt(r.about_mean() / (r.count - 1.0)); }},
                {"noise_sd", rate, [](const Repeats& r) { return std::sqrt(r.noise / r.count); }}}));
}

}  // namespace tumble::sdof_gyro_support
