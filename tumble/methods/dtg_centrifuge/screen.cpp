#include "tumble/methods/dtg_centrifuge/screen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/earth/earth.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Severity = Finding::Severity;

double deg_per_s(double rate) { return rate / si(1.0, "deg/s"); }

double turns_of(double rate, const Spin& s) { return std::abs(rate) * (s.end - s.begin) / two_pi; }

/// Which lines lie together, in words; empty: none of those the theory names.
std::string coincidence(const Measured& m) {
  for (int h = 1; h <= 3; ++h) {
    const double table = h * std::abs(m.theta_rate()), net = std::abs(m.beta_rate());
    if (turns_of(table - net, *m.stretch) < 2.0)
      return fmt::format(
          "{}the table's rate and the net rate are both {:.4g} deg/s: the sensitive term and the Earth's "
          "rate fall into one line",
          h == 1 ? "" : fmt::format("{} times ", h), deg_per_s(net));
  }
  return "";
}

std::string senses(const Measured& m) {
  const Spin& s = *m.stretch;
  std::string words;
  for (const auto& [name, planned, turned] :
       {std::tuple{"arm", s.arm_rate, m.arm_rate}, std::tuple{"table", s.table_rate, m.table_rate}})
    if (planned * turned < 0.0)
      words += fmt::format("{}the {} turns at {:.6g} deg/s by its encoder, but at {:.6g} deg/s by the plan",
                           words.empty() ? "" : ", ", name, deg_per_s(turned), deg_per_s(planned));
  return words.empty() ? ""
                       : words +
                             ": is the angle counted the other way? Angles count counter-clockwise seen from above, "
                             "the table's from the arm";
}

/// Why the level cannot be used; empty: it can.
std::string refusal(const Measured& m, bool fourier) {
  const Spin& s = *m.stretch;
  if (!m.fault.empty()) return m.fault;
  if (const auto words = senses(m); !words.empty()) return words;
  if (m.unsteady > 1e-3)
    return fmt::format(
        "the rates never settle: they differ by up to {:.2g} % within the segment; begin it later "
        "([settings] settling) or make it longer",
        100.0 * m.unsteady);
  if (const auto words = coincidence(m); !words.empty()) return words;
  if (turns_of(m.theta_rate(), s) < 3.0 || turns_of(m.beta_rate(), s) < 1.0)
    return fmt::format(
        "in {:.4g} s the table makes {:.2g} turns against the arm and {:.2g} in all: three and one are "
        "the least",
        s.end - s.begin, turns_of(m.theta_rate(), s), turns_of(m.beta_rate(), s));
  if (m.weakest < 0.02) return "the lines cannot be told apart at these rates and samples";
  if (fourier && m.of[reference].lost + m.of[gyro].lost > 0.5)
    return fmt::format("{:.0f} samples are missing, and whole periods need all: use estimator = \"regression\"",
                       std::max(m.of[reference].lost, m.of[gyro].lost));
  return "";
}

/// One finding for all segments with the same words.
class Collected {
 public:
  void add(Severity severity, const std::string& words, const std::string& where) {
    const auto known = std::ranges::find(all_, words, &Finding::message);
    if (known == all_.end())
      all_.push_back({severity, words, where});
    else if (++more_[words] < 4)
      known->where += "; " + where;
  }
  void into(Findings& findings) {
    for (auto& one : all_) {
      if (more_[one.message] >= 4) one.where += fmt::format("; and {} more", more_[one.message] - 3);
      findings.push_back(one);
    }
  }

 private:
  Findings all_;
  std::map<std::string, int> more_;
};

void compare_rates(const Measured& m, Collected& collected) {
  const Spin& s = *m.stretch;
  const double net = s.arm_rate + s.table_rate;
  const double off = std::max(std::abs(m.arm_rate / s.arm_rate - 1.0), std::abs(m.table_rate / s.table_rate - 1.0));
  const double net_off = net != 0.0 ? std::abs(m.beta_rate() / net - 1.0) : 0.0;
  if (off < 1e-3 && net_off < 1e-2) return;
  collected.add(Severity::warning,
                fmt::format("arm and table turn at {:.6g} and {:.6g} deg/s, net {:.5g}, but the plan says {:.6g} and "
                            "{:.6g}, net {:.5g}: the rates as turned are used",
                            deg_per_s(m.arm_rate), deg_per_s(m.table_rate), deg_per_s(m.beta_rate()),
                            deg_per_s(s.arm_rate), deg_per_s(s.table_rate), deg_per_s(net)),
                where_of(s));
}

}  // namespace

std::vector<Measured> screened(std::vector<Measured> measured, const Test& test, bool fourier, Findings& findings) {
  std::vector<Measured> good;
  Collected collected;
  std::vector<std::string> reasons;
  for (Measured& m : measured) {
    const Spin& s = *m.stretch;
    if (const auto why = refusal(m, fourier); !why.empty()) {
      collected.add(Severity::error, "the level is left out: " + why, where_of(s));
      reasons.push_back(where_of(s) + ": " + why);
      continue;
    }
    if (!m.of[gyro_y].fault.empty()) {
      collected.add(Severity::error, m.of[gyro_y].fault + ": left out", where_of(s));
      m.of[gyro_y].present = false;
    }
    compare_rates(m, collected);
    if (!test.encoders && !m.rates_found)
      collected.add(Severity::warning, "no line stands out at the table's rate, so the rates are taken from the plan",
                    where_of(s));
    if (m.unsteady > 1e-4)
      collected.add(Severity::warning,
                    "the rates of arm or table change by more than 0.01 % within the segment, the specific force by "
                    "twice as much",
                    where_of(s));
    if (fourier && turns_of(m.theta_rate(), s) <= 501.0)
      collected.add(
          Severity::warning,
          "the source wants more than 500 whole periods, and there are fewer: what is left of an offset leaks "
          "into the harmonic; a longer segment, or estimator = \"regression\", mends it",
          where_of(s));
    good.push_back(std::move(m));
  }
  collected.into(findings);
  if (good.empty()) throw Error(Error::Kind::bad_data, reasons);
  return good;
}

void check_earth(const std::vector<Measured>& measured, const Test& test, Findings& findings) {
  for (const Measured& m : measured) {
    const Lines& f = m.of[reference];
    const Plan& plan = *test.power_ups[m.stretch->power_up].plan;
    const double expected = earth_rate * std::cos(plan.site->latitude);
    const double seen = std::abs(f.value.earth), sd = f.residual_sd * std::sqrt(2.0 / f.samples);
    if (std::abs(seen - expected) < 8.0 * sd + 0.1 * expected) continue;
    const double unit = si(1.0, "deg/h");
    findings.push_back(
        {Severity::warning,
         fmt::format("at the net rate of {:.4g} deg/s the reference gyro shows {:.3g} deg/h, but the Earth "
                     "gives {:.3g}: are its unit and scale factor right, do the angles count the way they "
                     "turn, is its clock that of the angles, is it clipped?",
                     deg_per_s(m.beta_rate()), seen / unit, expected / unit),
         where_of(*m.stretch)});
    return;  // one says it
  }
}

}  // namespace tumble::dtg_centrifuge
