#include "tumble/methods/dtg_centrifuge/effects.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tumble/math/rounding_share.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dtg_centrifuge {
namespace {

/// A level as an instrument of the identified terms would show it on a rig.
Measured shown(const Circumstances& around, const Spin& stretch, const RigLines& lines, Complex term) {
  Measured out;
  out.stretch = &stretch;
  out.arm_rate = lines.arm_rate;
  out.table_rate = lines.table_rate;
  const double p = term.real(), q = term.imag();
  const double offset = around.output == gyro_y ? half_pi : 0.0;
  const double eta = around.relation.azimuth + offset, gain = std::exp(-around.relation.log_gain);
  const auto each = [](Phasors& sum, const Phasors& in, double factor) {
    for (std::size_t h = 0; h < 3; ++h) sum.line[h] += factor * in.line[h];
    sum.earth += factor * in.earth;
  };
  Phasors &g = out.of[around.output].value, &f = out.of[reference].value;
  each(g, lines.rate[around.output == gyro_y ? 1 : 0], 1.0);
  each(g, lines.force[0], p);
  each(g, lines.force[1], q);
  each(f, lines.rate[0], gain * std::cos(eta));
  each(f, lines.rate[1], gain * std::sin(eta));
  return out;
}

/// c as the Earth's lines of all cells give it, spin axis up.
Complex ratio(const std::vector<Measured>& cells, Signal output) {
  Complex above = 0.0;
  double below = 0.0;
  for (const Measured& m : cells) {
    const Complex product = m.of[output].value.earth * std::conj(m.of[reference].value.earth);
    above += m.stretch->spin_up < 0.0 ? std::conj(product) : product;
    below += std::norm(m.of[reference].value.earth);
  }
  return below > 0.0 ? above / below : Complex(1.0);
}

struct Terms {
  std::vector<Complex> value, second, third;
};

/// The estimator on cells as shown.
Terms estimated(const Circumstances& around, const std::vector<Measured>& cells, const std::vector<RigLines>& nominal,
                const Relation& relation) {
  Reduction reduction;
  reduction.nominal = nominal;
  reduction.level_of.assign(cells.size(), 0);
  Terms out;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Observation o =
        observe(cells[i], reduction, i, around.output, relation, 0.0, around.phase_known && !around.plain_difference);
    out.value.push_back(o.value);
    out.second.push_back(o.second);
    out.third.push_back(o.third);
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
  return most <= rounding_share * size;
}

/// Weight of the Earth's rate [1] in a gain or azimuth that is combined with what was known before.
double share_of_earth(double combined, double earth) {
  return std::isfinite(earth) && earth > 0.0 ? std::pow(combined / earth, 2) : earth == 0.0;
}

/// The relation with what a disturbance of the Earth's lines by a factor changes in it.
Relation disturbed_relation(const Circumstances& around, Complex factor) {
  Relation relation = around.relation;
  if (!relation.from_earth || around.plain_difference) return relation;
  const Complex change = std::log(factor);
  relation.log_gain += change.real() * share_of_earth(relation.log_gain_sd, relation.earth_sd);
  relation.azimuth -= change.imag() * share_of_earth(relation.azimuth_sd, relation.earth_sd);
  return relation;
}

/// An error that each segment draws anew: one effect for each observation.
void add_each(const Effect& effect, std::vector<Effect>& effects) {
  const std::size_t count = effect.value.size();
  for (std::size_t n = 0; n < count; ++n) {
    Effect single{effect.source, std::vector<Complex>(count), std::vector<Complex>(count), std::vector<Complex>(count)};
    single.value[n] = effect.value[n];
    single.second[n] = effect.second[n];
    single.third[n] = effect.third[n];
    effects.push_back(std::move(single));
  }
}

/// Plans that share a key share the error, if they state one standard deviation for it: see reduce/rig_effects.
void add_shared(Effect effect, std::vector<Effect>& effects) {
  const auto same = std::ranges::find_if(effects, [&](const Effect& other) {
    return !effect.key.empty() && other.key == effect.key && other.source == effect.source;
  });
  if (same != effects.end() && std::abs(same->sd - effect.sd) <= rounding_share * same->sd) {
    for (const auto part : {&Effect::value, &Effect::second, &Effect::third})
      for (std::size_t n = 0; n < effect.value.size(); ++n) ((*same).*part)[n] += (effect.*part)[n];
    return;
  }
  if (same != effects.end()) effect.key.clear();
  effects.push_back(std::move(effect));
}

/// A shift of y = p - i sigma q in each observation.
template <class Shift>
void add(const std::string& source, const Circumstances& around, const std::vector<Observation>& observations,
         const Shift& shift, std::vector<Effect>& effects) {
  Effect effect{source, {}, std::vector<Complex>(observations.size()), std::vector<Complex>(observations.size())};
  for (const Observation& o : observations) {
    const double sigma = around.measured[o.measured].stretch->spin_up;
    const Complex y = shift(o, sigma);
    effect.value.emplace_back(y.real(), -sigma * y.imag());
  }
  if (!negligible(effect.value, observations)) effects.push_back(std::move(effect));
}

Complex term(const Observation& o, double sigma) { return {o.value.real(), -sigma * o.value.imag()}; }

double number(const Circumstances& around, const char* name) {
  return around.settings.has(name) ? around.settings.number(name) : 0.0;
}

/// Clock of the reference gyro, and its own sensitivity.
void add_reference(const Circumstances& around, const std::vector<Observation>& observations,
                   std::vector<Effect>& effects) {
  const double sd = std::hypot(number(around, "reference_clock_offset_sd"), around.reference_late_sd);
  const auto clock = [&](const Observation& o, double) {
    const Measured& m = around.measured[o.measured];
    return -Complex(0.0, sd * (m.theta_rate() + m.beta_rate())) * o.true_rate / o.force;
  };
  add("clock of the reference gyro", around, observations, clock, effects);
  if (!around.sensitivity.known) return;
  for (const Complex part : {Complex(1.0), Complex(0.0, 1.0)}) {
    const auto own = [&](const Observation& o, double sigma) {
      const Complex v = around.sensitivity.sd * (sigma < 0.0 ? std::conj(part) : part);
      return std::conj(around.relation.c(sigma)) * v * std::abs(o.force) / o.force;
    };
    add("sensitivity of the reference gyro to specific force", around, observations, own, effects);
  }
}

void add_loop_lag(const Circumstances& around, const std::vector<Observation>& observations,
                  std::vector<Effect>& effects) {
  const double sd = number(around, "loop_lag_sd");
  if (!(sd > 0.0)) return;
  const Channelling loop = instruments_of(around.settings).of[around.output];
  Channelling slower = loop;
  slower.natural_frequency /= 1.0 + sd;
  slower.time_constant *= 1.0 + sd;
  const auto lag = [&](const Observation& o, double sigma) {
    const double rate = around.measured[o.measured].theta_rate();
    return term(o, sigma) * (loop.gain(rate, 0.0) / slower.gain(rate, 0.0) - 1.0);
  };
  add(lag_source, around, observations, lag, effects);
}

/// Lag that nobody stated takes kappa w^2 T (T + h)/2 from the amplitude: kappa = 1 for a low pass of first order, 0 for a loop of
/// second order with a damping ratio of 0.7, and -1 with 0.5; h is the time between samples where a program is the low pass.
void add_droop(const Circumstances& around, const std::vector<Observation>& observations, bool of_program,
               std::vector<Effect>& effects) {
  constexpr double kappa_sd = 0.7;
  const Lag& lag = around.lag;
  const double size = std::hypot(lag.value, lag.sd);
  Effect droop{"amplitude response of the loop", {}, {}, {}};
  for (const Observation& o : observations) {
    const Measured& m = around.measured[o.measured];
    const double step = of_program ? m.of[around.output].step : 0.0, sigma = m.stretch->spin_up;
    const double loss = -0.5 * kappa_sd * m.theta_rate() * m.theta_rate() * size * (size + step);
    const Complex shown = loss * o.raw / o.force;
    droop.value.emplace_back(shown.real(), -sigma * shown.imag());
    droop.second.push_back(4.0 * loss * o.second);
    droop.third.push_back(9.0 * loss * o.third);
  }
  if (!negligible(droop.value, observations)) effects.push_back(std::move(droop));
}

/// A loop that nobody stated, or one that the statement does not describe: its lag and its droop. The second may be a program too.
void add_unstated_loop(const Circumstances& around, const std::vector<Observation>& observations,
                       std::vector<Effect>& effects) {
  const Lag& lag = around.lag;
  if (!lag.quantity) effects.push_back(lag_effect(around, observations, lag.sd));
  if (!lag.of_stamps) add_droop(around, observations, lag.contradicted && lag.filter.stages == 0, effects);
}

/// Each with the harmonics of all, weighted: the noise of a single one would feign a lag that it does not have.
std::vector<Observation> with_mean_harmonics(std::vector<Observation> observations) {
  double second_weight = 0.0, third_weight = 0.0;
  Complex second, third;
  for (const Observation& o : observations) {
    const double by_second = std::pow(std::abs(o.force), 4), by_third = std::pow(std::abs(o.force), 6);
    second += by_second * o.second, second_weight += by_second;
    third += by_third * o.third, third_weight += by_third;
  }
  for (Observation& o : observations) o.second = second / second_weight, o.third = third / third_weight;
  return observations;
}

/// What the levels hint at: both parts of each cause, with its whole size.
void add_doubt(const Circumstances& around, const std::vector<Observation>& observations,
               std::vector<Effect>& effects) {
  const Doubt& doubt = around.doubt;
  for (const Complex part : {Complex(1.0), Complex(0.0, 1.0)}) {
    const auto beside = [&](const Observation& o, double sigma) {
      return doubt.beside * (sigma < 0.0 ? std::conj(part) : part) / o.force;
    };
    const auto relation = [&](const Observation& o, double sigma) {
      return -doubt.relation * Complex(part.real(), sigma * part.imag()) * o.true_rate / o.force;
    };
    if (doubt.beside > 0.0) add("line beside the specific force", around, observations, beside, effects);
    if (doubt.relation > 0.0) add(relation_source, around, observations, relation, effects);
  }
}

}  // namespace

double azimuth_of_lag(const Circumstances& around, const std::vector<Observation>& observations) {
  double sum = 0.0, weight = 0.0;
  for (const Observation& o : observations) {
    const Measured& m = around.measured[o.measured];
    const double samples = m.of[around.output].samples;
    sum += samples * m.stretch->spin_up * m.beta_rate();
    weight += samples;
  }
  return sum / weight * share_of_earth(around.relation.azimuth_sd, around.relation.earth_sd);
}

Effect lag_effect(const Circumstances& around, const std::vector<Observation>& observations, double seconds) {
  Effect effect{lag_source, {}, {}, {}};
  const double azimuth = azimuth_of_lag(around, observations);
  for (const Observation& o : observations) {
    const Measured& m = around.measured[o.measured];
    const double sigma = m.stretch->spin_up;
    const auto facing = [sigma](Complex y) { return Complex(y.real(), -sigma * y.imag()); };
    const Complex turn(0.0, -seconds * m.theta_rate()), true_rate(0.0, -seconds * sigma * azimuth);
    effect.value.push_back(facing((turn * o.raw + true_rate * o.true_rate) / o.force));
    effect.second.push_back(facing(2.0 * turn * facing(o.second)));
    effect.third.push_back(facing(3.0 * turn * facing(o.third)));
  }
  return effect;
}

std::vector<Effect> rig_effects(const Circumstances& around, const std::vector<Observation>& observations,
                                const std::vector<RigLinesShift>& shifts, const std::vector<std::size_t>& cell_of,
                                const std::vector<RigLines>& nominal, const std::vector<const Spin*>& cells) {
  std::vector<Complex> terms(cells.size());
  for (std::size_t n = 0; n < observations.size(); ++n) terms[cell_of[n]] = observations[n].value;
  const auto all_shown = [&](const std::vector<RigLines>& lines) {
    std::vector<Measured> out;
    for (std::size_t i = 0; i < cells.size(); ++i) out.push_back(shown(around, *cells[i], lines[i], terms[i]));
    return out;
  };
  const auto undisturbed = all_shown(nominal);
  const Complex before = ratio(undisturbed, around.output);
  const Terms here = estimated(around, undisturbed, nominal, around.relation);
  std::vector<Effect> effects;
  const auto keys = keys_of(around.test, shifts);
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    const RigLinesShift& shift = shifts[k];
    const auto disturbed = all_shown(shift.observed);
    const Relation relation = disturbed_relation(around, ratio(disturbed, around.output) / before);
    const Terms there = estimated(around, disturbed, nominal, relation);
    Effect effect{shift.error.error.name,
                  spread(there.value, here.value, cell_of),
                  spread(there.second, here.second, cell_of),
                  spread(there.third, here.third, cell_of),
                  keys[k],
                  shift.error.error.sd};
    if (negligible(effect.value, observations) && negligible(effect.second, observations) &&
        negligible(effect.third, observations))
      continue;
    if (shift.error.error.each_segment)
      add_each(effect, effects);
    else
      add_shared(std::move(effect), effects);
  }
  return effects;
}

std::vector<Effect> instrument_effects(const Circumstances& around, const std::vector<Observation>& observations) {
  std::vector<Effect> effects;
  const Relation& relation = around.relation;
  const double scale_factor_sd = number(around, "scale_factor_sd");
  const auto scale_factor = [&](const Observation& o, double sigma) { return scale_factor_sd * term(o, sigma); };
  const auto gain = [&](const Observation& o, double) { return -relation.log_gain_sd * o.true_rate / o.force; };
  const auto azimuth = [&](const Observation& o, double sigma) {
    return -Complex(0.0, sigma * relation.azimuth_sd) * o.true_rate / o.force;
  };
  add("scale factor", around, observations, scale_factor, effects);
  add(relation_source, around, observations, gain, effects);
  add(relation_source, around, observations, azimuth, effects);
  if (around.plain_difference) return effects;
  add_reference(around, observations, effects);
  if (around.lag.stated) add_loop_lag(around, observations, effects);
  add_doubt(around, observations, effects);
  if (around.lag.doubtful) {
    const auto mean = with_mean_harmonics(observations);
    effects.push_back(lag_effect(around, mean, around.lag.sd));
    add_droop(around, mean, true, effects);
  }
  if (!around.lag.stated || around.lag.contradicted) add_unstated_loop(around, observations, effects);
  return effects;
}

}  // namespace tumble::dtg_centrifuge
