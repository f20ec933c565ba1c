#include "tumble/methods/dtg_centrifuge/effects.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// A level as an instrument of the identified terms would show it on a rig.
Measured shown(const Circumstances& around, const Spin& stretch, const Seen& seen, Complex term) {
  Measured out;
  out.stretch = &stretch;
  out.arm_rate = seen.arm_rate;
  out.table_rate = seen.table_rate;
  const double p = term.real(), q = term.imag();
  const double offset = around.output == gyro_y ? half_pi : 0.0;
  const double eta = around.relation.azimuth + offset, gain = std::exp(-around.relation.log_gain);
  const auto each = [](Phasors& sum, const Phasors& in, double factor) {
    for (std::size_t h = 0; h < 3; ++h) sum.line[h] += factor * in.line[h];
    sum.earth += factor * in.earth;
  };
  Phasors &g = out.of[around.output].value, &f = out.of[reference].value;
  each(g, seen.rate[around.output == gyro_y ? 1 : 0], 1.0);
  each(g, seen.force[0], p);
  each(g, seen.force[1], q);
  each(f, seen.rate[0], gain * std::cos(eta));
  each(f, seen.rate[1], gain * std::sin(eta));
  return out;
}

/// c as the Earth's lines of all cells give it, spin axis up.
Complex ratio(const std::vector<Measured>& cells, Signal output) {
  Complex above = 0.0;
  double below = 0.0;
  for (const Measured& m : cells) {
    const Complex one = m.of[output].value.earth * std::conj(m.of[reference].value.earth);
    above += m.stretch->spin_up < 0.0 ? std::conj(one) : one;
    below += std::norm(m.of[reference].value.earth);
  }
  return below > 0.0 ? above / below : Complex(1.0);
}

struct Terms {
  std::vector<Complex> value, second, third;
};

/// The estimator on cells as shown.
Terms estimated(const Circumstances& around, const std::vector<Measured>& cells, const std::vector<Seen>& nominal,
                const Relation& relation) {
  Reduction reduction;
  reduction.nominal = nominal;
  reduction.level_of.assign(cells.size(), 0);
  Terms out;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Observation one =
        observe(cells[i], reduction, i, around.output, relation, 0.0, around.phase_known && !around.plain_difference);
    out.value.push_back(one.value);
    out.second.push_back(one.second);
    out.third.push_back(one.third);
  }
  return out;
}

std::vector<Complex> spread(const std::vector<Complex>& there, const std::vector<Complex>& here,
                            const std::vector<std::size_t>& cell_of) {
  std::vector<Complex> out;
  for (const std::size_t cell : cell_of) out.push_back(there[cell] - here[cell]);
  return out;
}

bool negligible(const std::vector<Complex>& shift, const std::vector<Observation>& observations) {
  double size = 0.0, most = 0.0;
  for (const auto& one : observations) size = std::max(size, std::abs(one.value));
  for (const Complex one : shift) most = std::max(most, std::abs(one));
  return most <= 1e-9 * size;
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): 44 lines; to be split when it changes
std::vector<Effect> rig_effects(const Circumstances& around, const std::vector<Observation>& observations,
                                const std::vector<SeenShift>& shifts, const std::vector<std::size_t>& cell_of,
                                const std::vector<Seen>& nominal, const std::vector<const Spin*>& cells) {
  std::vector<Complex> term(cells.size());
  for (std::size_t n = 0; n < observations.size(); ++n) term[cell_of[n]] = observations[n].value;
  const auto all_shown = [&](const std::vector<Seen>& seen) {
    std::vector<Measured> out;
    for (std::size_t i = 0; i < cells.size(); ++i) out.push_back(shown(around, *cells[i], seen[i], term[i]));
    return out;
  };
  const auto undisturbed = all_shown(nominal);
  const Complex before = ratio(undisturbed, around.output);
  const Terms here = estimated(around, undisturbed, nominal, around.relation);
  const auto share = [](double combined, double earth) {
    return std::isfinite(earth) && earth > 0.0 ? std::pow(combined / earth, 2) : earth == 0.0;
  };
  std::vector<Effect> effects;
  for (const SeenShift& shift : shifts) {
    const auto disturbed = all_shown(shift.observed);
    Relation relation = around.relation;
    if (relation.from_earth && !around.plain_difference) {
      const Complex change = std::log(ratio(disturbed, around.output) / before);
      relation.log_gain += change.real() * share(relation.log_gain_sd, relation.earth_sd);
      relation.azimuth -= change.imag() * share(relation.azimuth_sd, relation.earth_sd);
    }
    const Terms there = estimated(around, disturbed, nominal, relation);
    Effect effect{shift.error.error.name, spread(there.value, here.value, cell_of),
                  spread(there.second, here.second, cell_of), spread(there.third, here.third, cell_of)};
    if (negligible(effect.value, observations) && negligible(effect.second, observations) &&
        negligible(effect.third, observations))
      continue;
    if (!shift.error.error.each_segment) {
      effects.push_back(std::move(effect));
      continue;
    }
    const Effect none{shift.error.error.name, std::vector<Complex>(cell_of.size()),
                      std::vector<Complex>(cell_of.size()), std::vector<Complex>(cell_of.size())};
    for (std::size_t n = 0; n < cell_of.size(); ++n) {
      Effect one = none;
      one.value[n] = effect.value[n];
      one.second[n] = effect.second[n];
      one.third[n] = effect.third[n];
      effects.push_back(std::move(one));
    }
  }
  return effects;
}

// NOLINTNEXTLINE(readability-function-size): 45 lines; to be split when it changes
std::vector<Effect> instrument_effects(const Circumstances& around, const std::vector<Observation>& observations) {
  std::vector<Effect> effects;
  /// `shift(observation, sigma)` of y = p - i sigma q
  const auto add = [&](const std::string& source, auto shift) {
    Effect effect{source, {}, std::vector<Complex>(observations.size()), std::vector<Complex>(observations.size())};
    for (const Observation& one : observations) {
      const double sigma = around.measured[one.measured].stretch->spin_up;
      const Complex y = shift(one, sigma);
      effect.value.emplace_back(y.real(), -sigma * y.imag());
    }
    if (!negligible(effect.value, observations)) effects.push_back(std::move(effect));
  };
  const auto number = [&](const char* name) { return around.settings.has(name) ? around.settings.number(name) : 0.0; };
  const auto term = [](const Observation& one, double sigma) {
    return Complex(one.value.real(), -sigma * one.value.imag());
  };
  add("scale factor",
      [&, sd = number("scale_factor_sd")](const Observation& one, double sigma) { return sd * term(one, sigma); });
  const Relation& relation = around.relation;
  add(relation_source,
      [&](const Observation& one, double) { return -relation.log_gain_sd * one.true_rate / one.force; });
  add(relation_source, [&](const Observation& one, double sigma) {
    return -Complex(0.0, sigma * relation.azimuth_sd) * one.true_rate / one.force;
  });
  if (around.plain_difference) return effects;
  add("clock of the reference gyro", [&, sd = number("reference_clock_offset_sd")](const Observation& one, double) {
    const Measured& m = around.measured[one.measured];
    return -Complex(0.0, sd * (m.theta_rate() + m.beta_rate())) * one.true_rate / one.force;
  });
  if (around.sensitivity.known)
    for (const Complex part : {Complex(1.0), Complex(0.0, 1.0)})
      add("sensitivity of the reference gyro to specific force", [&](const Observation& one, double sigma) {
        const Complex v = around.sensitivity.sd * (sigma < 0.0 ? std::conj(part) : part);
        return std::conj(relation.c(sigma)) * v * std::abs(one.force) / one.force;
      });
  if (const double sd = number("loop_lag_sd"); sd > 0.0) {
    Channelling loop = instruments_of(around.settings).of[around.output], other = loop;
    other.natural_frequency /= 1.0 + sd;
    other.time_constant *= 1.0 + sd;
    add("lag of the loop", [&](const Observation& one, double sigma) {
      const double rate = around.measured[one.measured].theta_rate();
      return term(one, sigma) * (loop.gain(rate, 0.0) / other.gain(rate, 0.0) - 1.0);
    });
  }
  return effects;
}

}  // namespace tumble::dtg_centrifuge
