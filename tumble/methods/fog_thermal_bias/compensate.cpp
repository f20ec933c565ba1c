#include "tumble/methods/fog_thermal_bias/compensate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/sampling_rate.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/methods/fog_thermal_bias/data.hpp"
#include "tumble/methods/fog_thermal_bias/departures.hpp"
#include "tumble/methods/fog_thermal_bias/range.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/error.hpp"

namespace tumble::fog_thermal_bias {
namespace {

using compensation::KnownTerms;

/// Faults of a result file that was edited or damaged: an identification does not write them.
std::vector<std::string> faults_of(const Estimate& estimate, const std::vector<Term>& terms) {
  std::vector<std::string> faults;
  for (const auto& parameter : estimate.parameters) {
    const auto term = std::ranges::find(terms, parameter.name, &Term::name);
    const bool score = parameter.name.starts_with("bias_sd_") || parameter.name == "turn_on_repeatability";
    if (term == terms.end() && !score)
      faults.push_back(fmt::format("the result's parameter '{}' is not a term of the thermal model", parameter.name));
    if (term != terms.end() && Unit::parse(term->unit).dimension() != parameter.unit.dimension())
      faults.push_back(fmt::format("the result's parameter '{}' is in {}, but must be in {} or another unit of [{}]",
                                   parameter.name, parameter.unit.text(), term->unit,
                                   name(Unit::parse(term->unit).dimension())));
    if (!std::isfinite(parameter.value))
      faults.push_back(fmt::format("the result's parameter '{}' has no value", parameter.name));
  }
  const Table* range = find_table(estimate, "calibrated_range");
  if (range == nullptr || range->rows.empty() || range->columns.size() != 6)
    faults.push_back("the result has no table calibrated_range, which says where the compensation holds");
  for (const auto& option : find_method("fog_thermal_bias").options())
    if (!option.fallback.empty() && !estimate.provenance.settings.contains(option.name))
      faults.push_back(fmt::format("the result's provenance lacks the setting '{}'", option.name));
  return faults;
}

KnownTerms drift_of(const Estimate& estimate, const Settings& settings) {
  auto terms = find_model("fiber_optic_gyro").outputs(constants_of(settings))[0].terms;
  if (const auto faults = faults_of(estimate, terms); !faults.empty()) throw Error(Error::Kind::bad_file, faults);
  std::erase_if(terms, [](const Term& term) { return term.name.starts_with("bias_"); });  // the level stays
  KnownTerms drift = compensation::known_terms(estimate, terms);
  if (drift.terms.empty()) throw Error(Error::Kind::bad_file, "the result holds no coefficient of the thermal model");
  return drift;
}

struct Channels {
  std::size_t gyro;
  Sensors sensors;
};

Channels channels_of(const Estimate& estimate, const Recording& recording) {
  Channels out{};
  Problems problems;
  const auto gyro = compensation::output_of(estimate, recording, "gyro", problems);
  out.sensors = {channel_of(estimate, recording, "temperature_top"),
                 channel_of(estimate, recording, "temperature_side")};
  if (out.sensors.top == nullptr || out.sensors.side == nullptr)
    out.sensors = {channel_of(estimate, recording, "temperature"), nullptr};
  if (out.sensors.top == nullptr)
    problems.push_back("the recording has no channel for temperature (or temperature_top and temperature_side)");
  if (out.sensors.side == nullptr && find_parameter(estimate, "B1_0") != nullptr)
    problems.push_back(
        "the result uses the temperature gradient: the recording needs temperature_top and temperature_side");
  if (gyro) compensation::require_dimension(&recording.channels[*gyro], "deg/h", problems);
  for (const Channel* sensor : {out.sensors.top, out.sensors.side})
    compensation::require_dimension(sensor, "degC", problems);
  compensation::refuse(recording, problems);
  out.gyro = *gyro;
  for (const Channel* channel : {&recording.channels[out.gyro], out.sensors.top, out.sensors.side})
    if (channel != nullptr) refuse_backward(*channel);
  return out;
}

/// Outcome of the compensation of one power-up.
struct Outcome {
  double start_temperature = 0.0, sd_raw = 0.0, sd_compensated = 0.0;
  double outside = 0.0;  ///< share of the samples outside of the calibrated range
  double first_outside = 0.0;
  std::size_t blank = 0;  ///< samples without a temperature
};

/// Which intervals since power-on lie outside of the range: judged on averages, as the range was made of averages.
std::vector<bool> outside_of(const InRange& in_range, const Thermal& thermal, double interval) {
  std::vector<bool> outside;
  std::size_t k = 0;
  while (k < thermal.felt.size()) {
    const double end = interval * static_cast<double>(outside.size() + 1);
    Felt mean{{}, {}, {}, 0.0, 0.0, 0.0, thermal.start_temperature, 0.0};
    double count = 0.0;
    for (; k < thermal.felt.size() && thermal.felt[k].since_power_on < end; ++k) {
      if (std::isnan(thermal.felt[k].temperature)) continue;
      mean.temperature += thermal.felt[k].temperature;
      mean.temperature_gradient += thermal.felt[k].temperature_gradient;
      mean.temperature_rate += thermal.felt[k].temperature_rate;
      count += 1.0;
    }
    mean.temperature /= count;
    mean.temperature_gradient /= count;
    mean.temperature_rate /= count;
    outside.push_back(count > 0.0 && !in_range(mean));
  }
  return outside;
}

/// One finding for all runs.
Finding extrapolation(const std::vector<Run>& runs, const std::vector<Outcome>& outcomes, const std::string& channel) {
  std::string where;
  Occurrences occurrences{.count = 0, .first = {}, .worst = {}};
  double worst = 0.0, begin = 0.0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (outcomes[r].outside == 0.0) continue;
    const Place place(fmt::format("run {}", runs[r].number), outcomes[r].first_outside);
    where += (where.empty() ? "run " : ", ") + std::to_string(runs[r].number);
    if (occurrences.count++ == 0) {
      occurrences.first = place;
      begin = outcomes[r].first_outside;
    }
    if (outcomes[r].outside <= worst) continue;
    worst = outcomes[r].outside;
    occurrences.worst = place;
  }
  return {Finding::Severity::warning,
          "outside_calibrated_range",
          {{"share", worst, "%"}, {"begin", begin, "s"}, {"channel", channel}},
          where,
          occurrences};
}

double sd_of_averages(const std::vector<double>& values, std::size_t first, std::size_t last, std::size_t each) {
  std::vector<double> means;
  for (std::size_t at = first; at + each <= last; at += each) {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = at; k < at + each; ++k)
      if (!std::isnan(values[k])) {
        sum += values[k];
        count += 1.0;
      }
    if (count > 0.0) means.push_back(sum / count);
  }
  double mean = 0.0, squares = 0.0;
  for (const double m : means) mean += m / static_cast<double>(means.size());
  for (const double m : means) squares += (m - mean) * (m - mean);
  return means.size() > 1 ? std::sqrt(squares / static_cast<double>(means.size() - 1)) : std::nan("");
}

/// The gyro as it was and as it becomes, with the channels written beside it.
struct Written {
  const Channel& raw;
  Channel& gyro;
  compensation::Trust trust;
};

/// Correction that all runs share.
struct Correction {
  const Settings& settings;
  const KnownTerms& drift;
  const InRange& in_range;
  double misfit;  ///< [rad/s] sd of the drift that the model does not follow
  double rate;    ///< [Hz] of the gyro's clock, so that lost samples do not change the averages
};

Outcome compensate_run(const Correction& correction, const Sensors& sensors, const Run& run, Written& written) {
  const auto& [settings, drift, in_range, misfit, rate] = correction;
  const Thermal thermal = thermal_of(sensors, run.begin, run.end, settings, settings.number("sensor_lag"));
  const Channel& raw = written.raw;
  const auto [first, last] = samples_between(raw, run.begin, run.end);
  const double interval = settings.number("averaging");
  const auto intervals_outside = outside_of(in_range, thermal, interval);
  std::vector<double> phi;
  Outcome out;
  for (std::size_t k = first; k < last; ++k) {
    const Felt felt = felt_at(thermal, raw.time(k));
    const auto [predicted, sd] = compensation::predicted(drift, felt, phi);
    double& value = written.gyro.values[k];
    out.blank += std::isnan(predicted) && !std::isnan(value);
    value -= predicted;
    written.trust.sd.values[k] = std::hypot(sd, misfit);
    const auto at = std::min(intervals_outside.size() - 1, static_cast<std::size_t>(felt.since_power_on / interval));
    written.trust.extrapolated.values[k] = intervals_outside[at] ? 1.0 : 0.0;
    if (intervals_outside[at] && out.outside++ == 0.0) out.first_outside = raw.time(k);
  }
  const auto each = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(interval * rate)));
  out.start_temperature = thermal.start_temperature;
  out.sd_raw = sd_of_averages(raw.values, first, last, each);
  out.sd_compensated = sd_of_averages(written.gyro.values, first, last, each);
  if (last > first) out.outside /= static_cast<double>(last - first);
  return out;
}

Table table_of(const std::vector<Run>& runs, const std::vector<Outcome>& outcomes) {
  const Unit one, rate = Unit::parse("deg/h");
  Table table{"compensation",
              "sd of the averages about their run's mean, before and after",
              {{"run", one},
               {"label", one},
               {"start temperature", Unit::parse("degC")},
               {"sd raw", rate},
               {"sd compensated", rate},
               {"ratio", one},
               {"outside calibrated range", Unit::parse("%")}},
              {}};
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Outcome& o = outcomes[r];
    table.rows.push_back({static_cast<double>(runs[r].number), runs[r].label, o.start_temperature, o.sd_raw,
                          o.sd_compensated, o.sd_compensated / o.sd_raw, o.outside});
  }
  return table;
}

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan*) {
  const Settings settings = settings_of(estimate, find_method("fog_thermal_bias").options());
  const KnownTerms drift = drift_of(estimate, settings);
  const Channels channels = channels_of(estimate, recording);
  const InRange in_range(*find_table(estimate, "calibrated_range"));
  Compensation out{recording, {}, {}};
  const Channel& raw = recording.channels[channels.gyro];
  Written written{raw, out.recording.channels[channels.gyro], compensation::trust_in(raw)};
  const Correction correction{settings, drift, in_range, misfit_in(estimate), sampling_rate(written.raw)};
  const auto runs = runs_of({recording});
  std::vector<Outcome> outcomes(runs.size());
  parallel_for(runs.size(),
               [&](std::size_t r) { outcomes[r] = compensate_run(correction, channels.sensors, runs[r], written); });
  std::size_t blank = 0;
  for (const auto& outcome : outcomes) blank += outcome.blank;
  if (blank > 0)
    out.findings.push_back(
        {Finding::Severity::warning, "samples_without_temperature", {}, written.raw.name, {blank, {}, {}}});
  if (std::ranges::any_of(outcomes, [](const Outcome& o) { return o.outside > 0.0; }))
    out.findings.push_back(extrapolation(runs, outcomes, written.trust.extrapolated.name));
  out.recording.channels.push_back(std::move(written.trust.sd));
  out.recording.channels.push_back(std::move(written.trust.extrapolated));
  out.tables.push_back(table_of(runs, outcomes));
  return out;
}

}  // namespace tumble::fog_thermal_bias
