#include "tumble/methods/dtg_centrifuge/screen.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Severity = Finding::Severity;

/// [turns in the segment] between two lines that coincide: each is one turn wide on both sides.
constexpr double turns_apart = 2.0;
constexpr int harmonics_of_table = 3;  ///< that carry the sensitive terms or the Earth's rate
/// [turns] of the table against the arm, and of both together, that a segment needs: three for a line beside an offset
/// and a ramp, one for the Earth's.
constexpr double fewest_table_turns = 3.0, fewest_net_turns = 1.0;
constexpr double least_weakest =
    0.02;                          ///< [1] of the lines that are distinguished. Chosen: noise is then 50 times larger
constexpr double most_lost = 0.5;  ///< [samples] none may be missing in whole periods
/// [1] change of the rates within a segment. The specific force changes by twice as much: 200 ppm are a warning, 2000
/// ppm refuse the level.
constexpr double unsteady_warning = 1e-4, unsteady_refused = 1e-3;
constexpr double fewest_periods = 500.0;  ///< whole periods that the source asks for; a part of one comes in addition
constexpr double explained_sd = 6.0;      ///< standard deviations of the plan's error of the rates
/// [1] of a rate, and of the net rate, which is a small difference of two, that the drives may be off without an entry
/// in the plan. Chosen: doubled, a table that lost one turn in 500 is accepted.
constexpr double rate_tolerance = 1e-3, net_tolerance = 1e-2;
/// Standard deviations and [1] of the Earth's rate. Chosen: a tenth is more than a reference gyro errs by in its scale
/// factor, and less than a wrong unit or clock.
constexpr double earth_sd = 8.0, earth_share = 0.1;

double turns_of(double rate, const Spin& s) { return std::abs(rate) * (s.end - s.begin) / two_pi; }

/// Whether findings say one thing: their codes, and their values that are names or numbers of something, agree.
bool same(const Finding& a, const Finding& b) {
  if (a.code != b.code) return false;
  return std::ranges::equal(a.values, b.values, [](const FindingValue& v, const FindingValue& w) {
    if (const auto* name = std::get_if<std::string>(&v.value)) return *name == std::get<std::string>(w.value);
    if (const auto* number = std::get_if<long long>(&v.value)) return *number == std::get<long long>(w.value);
    return true;
  });
}

/// One finding for each thing: how often it was made, where first, and where worst, with the values of the worst.
class Collected {
 public:
  /// Given: size [1], by which the worst is chosen.
  void add(Finding finding, double size = 0.0) {
    auto entry = std::ranges::find_if(all_, [&](const Entry& other) { return same(other.finding, finding); });
    if (entry == all_.end()) entry = all_.insert(entry, {finding, {}, size});
    entry->places.push_back(finding.where);
    if (size <= entry->size) return;
    entry->size = size;
    entry->finding = std::move(finding);
  }
  void into(Findings& findings) const {
    for (auto [finding, places, size] : all_) {
      finding.occurrences = {places.size(), places.front(), finding.where};
      if (places.size() > most_places) places = {places.front(), "...", places.back()};
      finding.where.clear();
      for (const std::string& place : places) finding.where += (finding.where.empty() ? "" : "; ") + place;
      finding.message = sentence(finding);
      findings.push_back(std::move(finding));
    }
  }

 private:
  static constexpr std::size_t most_places = 4;
  struct Entry {
    Finding finding;  ///< the worst
    std::vector<std::string> places;
    double size;
  };
  std::vector<Entry> all_;
};

void check_senses(const Measured& m, Findings& findings) {
  const Spin& s = *m.stretch;
  const Unit unit = Unit::parse("deg/s");
  if (s.arm_rate * m.arm_rate < 0.0)
    findings.push_back({Severity::error,
                        "arm_turns_the_other_way",
                        {{"turned", m.arm_rate, unit}, {"planned", s.arm_rate, unit}},
                        where_of(s)});
  if (s.table_rate * m.table_rate < 0.0)
    findings.push_back({Severity::error,
                        "table_turns_the_other_way",
                        {{"turned", m.table_rate, unit}, {"planned", s.table_rate, unit}},
                        where_of(s)});
}

/// A finding where a harmonic of the table's rate is the net rate.
void check_coincidence(const Measured& m, Findings& findings) {
  const double net = std::abs(m.beta_rate());
  for (int harmonic = 1; harmonic <= harmonics_of_table; ++harmonic)
    if (turns_of(harmonic * std::abs(m.theta_rate()) - net, *m.stretch) < turns_apart) {
      findings.push_back(
          {Severity::error, "lines_coincide", {{"net", net, "deg/s"}, {"harmonic", harmonic}}, where_of(*m.stretch)});
      return;
    }
}

void check_lines(const Measured& m, bool fourier, Findings& findings) {
  const Spin& s = *m.stretch;
  const double lost = std::max(m.of[reference].lost, m.of[gyro].lost);
  if (turns_of(m.theta_rate(), s) < fewest_table_turns || turns_of(m.beta_rate(), s) < fewest_net_turns)
    findings.push_back({Severity::error,
                        "too_few_turns",
                        {{"length", s.end - s.begin, "s"},
                         {"against_arm", turns_of(m.theta_rate(), s)},
                         {"net", turns_of(m.beta_rate(), s)}},
                        where_of(s)});
  else if (m.weakest < least_weakest)
    findings.push_back({Severity::error, "lines_not_distinguished", {}, where_of(s)});
  else if (fourier && lost > most_lost)
    findings.push_back({Severity::error, "samples_missing_in_whole_periods", {{"lost", lost}}, where_of(s)});
}

/// Why the level cannot be used, by the first check that fails; empty: it can.
Findings refusals(const Measured& m, bool fourier) {
  Findings findings = m.faults;
  if (findings.empty()) check_senses(m, findings);
  if (findings.empty() && m.unsteady > unsteady_refused)
    findings.push_back({Severity::error, "rates_do_not_settle", {{"change", m.unsteady, "%"}}, where_of(*m.stretch)});
  if (findings.empty()) check_coincidence(m, findings);
  if (findings.empty()) check_lines(m, fourier, findings);
  return findings;
}

/// What the drives explain: `explained_sd` standard deviations of the plan's error of the rates [1].
double explained_by_drives(const Settings& rig) {
  return rig.has("rate_error_sd") ? explained_sd * rig.number("rate_error_sd") : 0.0;
}

void compare_rates(const Measured& m, double explained, Collected& collected) {
  const Spin& s = *m.stretch;
  const double net = s.arm_rate + s.table_rate;
  const double off = std::max(std::abs(m.arm_rate / s.arm_rate - 1.0), std::abs(m.table_rate / s.table_rate - 1.0));
  const double net_off = net != 0.0 ? std::abs(m.beta_rate() / net - 1.0) : 0.0;
  const double net_explained = net != 0.0 ? explained * std::hypot(s.arm_rate, s.table_rate) / std::abs(net) : 0.0;
  if (off < std::max(rate_tolerance, explained) && net_off < std::max(net_tolerance, net_explained)) return;
  const Unit unit = Unit::parse("deg/s");
  collected.add({Severity::warning,
                 "rates_differ_from_plan",
                 {{"arm", m.arm_rate, unit},
                  {"table", m.table_rate, unit},
                  {"net", m.beta_rate(), unit},
                  {"planned_arm", s.arm_rate, unit},
                  {"planned_table", s.table_rate, unit},
                  {"planned_net", net, unit}},
                 where_of(s)},
                off);
}

/// Warnings of a level that is used.
void warn(const Measured& m, const Test& test, bool fourier, Collected& collected) {
  const std::string where = where_of(*m.stretch);
  compare_rates(m, explained_by_drives(test.power_ups[m.stretch->power_up].plan->rig), collected);
  if (!test.encoders && !m.rates_visible) collected.add({Severity::warning, "no_line_at_table_rate", {}, where});
  if (m.unsteady > unsteady_warning)
    collected.add({Severity::warning, "rates_change_within_segment", {{"change", m.unsteady, "%"}}, where}, m.unsteady);
  if (const double turns = turns_of(m.theta_rate(), *m.stretch); fourier && turns <= fewest_periods + 1.0)
    collected.add({Severity::warning, "few_whole_periods", {{"periods", std::floor(turns)}}, where}, 1.0 / turns);
}

}  // namespace

std::vector<Measured> screened(std::vector<Measured> measured, const Test& test, bool fourier, Findings& findings) {
  std::vector<Measured> good;
  Collected collected;
  Findings refused;
  for (Measured& m : measured) {
    if (const Findings why = refusals(m, fourier); !why.empty()) {
      for (const Finding& finding : why) collected.add(finding);
      refused.insert(refused.end(), why.begin(), why.end());
      continue;
    }
    for (const Finding& finding : m.of[gyro_y].faults) collected.add(finding);
    if (!m.of[gyro_y].faults.empty()) m.of[gyro_y].present = false;
    warn(m, test, fourier, collected);
    good.push_back(std::move(m));
  }
  collected.into(findings);
  if (good.empty()) throw Error(Error::Kind::bad_data, errors_among(refused));
  return good;
}

void check_earth(const std::vector<Measured>& measured, const Test& test, Findings& findings) {
  const Unit unit = Unit::parse("deg/h");
  Collected collected;
  for (const Measured& m : measured) {
    const Lines& f = m.of[reference];
    const Plan& plan = *test.power_ups[m.stretch->power_up].plan;
    const double expected = earth_rate * std::cos(plan.site->latitude), shown = std::abs(f.value.earth);
    const double off = std::abs(shown - expected), sd = f.residual_sd * std::sqrt(2.0 / f.samples);
    if (off < earth_sd * sd + earth_share * expected) continue;
    collected.add({Severity::warning,
                   "earth_rate_differs",
                   {{"net", m.beta_rate(), "deg/s"}, {"shown", shown, unit}, {"expected", expected, unit}},
                   where_of(*m.stretch)},
                  off);
  }
  collected.into(findings);
}

}  // namespace tumble::dtg_centrifuge
