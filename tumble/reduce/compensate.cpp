#include "tumble/reduce/compensate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "tumble/reduce/compensation/inputs.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using compensation::input_count;
using compensation::Inputs;
using compensation::inputs;

constexpr std::size_t block = 4096;           ///< samples
constexpr double tolerance = 1e-12;           ///< of the size of u
constexpr double greatest_error_slope = 0.5;  ///< dE/du beyond which the model is no model of errors
constexpr int most_steps = 30;

struct UsedTerm {
  Term term;
  std::size_t parameter = 0;
  double coefficient = 0.0, least = 0.0, greatest = 0.0;
  std::vector<std::size_t> missing;  ///< inputs
  std::set<std::string> from;        ///< where the others come from
  double sum = 0.0, squares = 0.0, largest = 0.0;
};

/// A model with the numbers of a result.
struct Work {
  const ErrorModel* model = nullptr;
  const Estimate* estimate = nullptr;
  std::vector<UsedTerm> terms, staying;  ///< subtracted, and those whose inputs are missing
  double scale_factor = 1.0;
  std::size_t scale_parameter = SIZE_MAX;
  double staying_variance = 0.0;
};

struct Counts {
  std::size_t samples = 0, outside = 0, blank = 0, lost = 0;
  double first_outside = 0.0;
};

std::size_t index_of(const Estimate& estimate, const std::string& name) {
  const auto match = std::ranges::find(estimate.parameters, name, &Parameter::name);
  return static_cast<std::size_t>(match - estimate.parameters.begin());
}

/// Limits of each regressor by parameter name.
std::map<std::string, std::pair<double, double>> limits_of(const Estimate& estimate) {
  const Table* table = find_table(estimate, regressors_name);
  if (!table || table->columns.size() != 3)
    throw Error(Error::Kind::bad_file,
                "the result has no table regressors: it cannot be said where the compensation holds; identify again");
  std::map<std::string, std::pair<double, double>> limits;
  for (const auto& row : table->rows)
    if (const auto* name = std::get_if<std::string>(&row[0]))
      limits[*name] = {std::get<double>(row[1]), std::get<double>(row[2])};
  return limits;
}

std::vector<UsedTerm> used_terms(const ErrorModel& model, const Estimate& estimate) {
  const auto limits = limits_of(estimate);
  std::vector<std::string> faults;
  std::vector<UsedTerm> out;
  for (const Term& term : model.terms) {
    const std::size_t p = index_of(estimate, term.name);
    if (p == estimate.parameters.size()) continue;
    const auto range = limits.find(term.name);
    const double value = estimate.parameters[p].value;
    if (!std::isfinite(value)) faults.push_back(fmt::format("the result's parameter '{}' has no value", term.name));
    if (range == limits.end())
      faults.push_back(
          fmt::format("the result's table regressors does not say what the test covered of '{}'", term.name));
    else
      out.push_back({term, p, value, range->second.first, range->second.second, {}, {}});
  }
  if (out.empty() && model.scale_factor.empty() && faults.empty())
    faults.emplace_back("the result has none of the model's terms: nothing can be subtracted");
  if (!faults.empty()) throw Error(Error::Kind::bad_file, faults);
  return out;
}

bool is_shown(const ErrorModel& model, std::size_t input) {
  Felt felt;
  return &inputs()[input].of(felt) == &model.shown(felt);
}

/// Terms whose inputs are all known, and the others.
void sort_terms(const Inputs& known, std::vector<UsedTerm> terms, Work& work) {
  for (auto& used : terms) {
    const auto needed = compensation::needs(used.term);
    for (std::size_t k = 0; k < input_count; ++k) {
      if (!needed[k]) continue;
      if (is_shown(*work.model, k))
        used.from.insert("the channel itself");
      else if (known.from[k].empty())
        used.missing.push_back(k);
      else
        used.from.insert(known.from[k]);
    }
    const double middle = 0.5 * (used.least + used.greatest), width = used.greatest - used.least;
    if (!used.missing.empty())
      work.staying_variance +=
          (used.coefficient * used.coefficient + work.estimate->covariance(used.parameter, used.parameter)) *
          (middle * middle + width * width / 12.0);
    (used.missing.empty() ? work.terms : work.staying).push_back(std::move(used));
  }
}

void set_scale_factor(Work& work) {
  if (work.model->scale_factor.empty()) return;
  work.scale_parameter = index_of(*work.estimate, work.model->scale_factor);
  if (work.scale_parameter == work.estimate->parameters.size())
    throw Error(Error::Kind::bad_file, "the result has no parameter " + work.model->scale_factor);
  work.scale_factor = work.estimate->parameters[work.scale_parameter].value;
  if (!std::isfinite(work.scale_factor) || work.scale_factor == 0.0)
    throw Error(Error::Kind::bad_file, "the result's parameter '" + work.model->scale_factor + "' has no value");
}

double errors_at(const Work& work, Felt& felt, double u) {
  work.model->shown(felt) = u;
  double sum = 0.0;
  for (const auto& used : work.terms) sum += used.coefficient * used.term.regressor(felt);
  return sum;
}

/// dE/du by the difference over a small step to both sides.
double error_slope(const Work& work, Felt& felt, double u) {
  const double step = 1e-4 * std::max(std::abs(u), 1e-6);
  return (errors_at(work, felt, u + step) - errors_at(work, felt, u - step)) / (2.0 * step);
}

/// u and dE/du there; NaN where there is no root of which the model is sure.
struct Solved {
  double value = std::nan(""), slope = 0.0;
};

Solved solve(const Work& work, Felt& felt, double y) {
  double u = y;
  for (int n = 0; n < most_steps; ++n) {
    const double slope = error_slope(work, felt, u), g = u + errors_at(work, felt, u) - y;
    if (!(std::abs(slope) < greatest_error_slope)) return {};
    if (std::abs(g) <= (1.0 - std::abs(slope)) * tolerance * std::max(std::abs(u), std::abs(y))) return {u, slope};
    u -= g / (1.0 + slope);
  }
  return {};
}

/// d' C d with d the derivatives of u by the parameters.
double variance_of(const Work& work, const std::vector<double>& x, double y, double slope) {
  std::vector<std::pair<std::size_t, double>> d;
  for (std::size_t t = 0; t < x.size(); ++t) d.emplace_back(work.terms[t].parameter, -x[t] / (1.0 + slope));
  if (work.scale_parameter != SIZE_MAX) d.emplace_back(work.scale_parameter, -y / work.scale_factor / (1.0 + slope));
  double sum = 0.0;
  for (const auto& [i, a] : d)
    for (const auto& [j, b] : d) sum += a * b * work.estimate->covariance(i, j);
  return std::max(0.0, sum);
}

bool outside(const UsedTerm& used, double x) {
  const double slack =
      0.02 * (used.greatest - used.least) + 1e-6 * std::max(std::abs(used.least), std::abs(used.greatest));
  return x < used.least - slack || x > used.greatest + slack;
}

/// One sample: u in place of the output, its uncertainty, and whether the calibration covered it.
void take_sample(Work& work, Felt& felt, double& value, double& sd, double& flag, std::vector<double>& x) {
  const double y = value * work.model->scale / work.scale_factor;
  const auto [u, slope] = solve(work, felt, y);
  value = u;
  sd = flag = std::isnan(u) ? std::nan("") : 0.0;
  if (std::isnan(u)) return;
  work.model->shown(felt) = u;
  for (std::size_t t = 0; t < x.size(); ++t) {
    UsedTerm& used = work.terms[t];
    x[t] = used.term.regressor(felt);
    const double part = used.coefficient * x[t];
    used.sum += part;
    used.squares += part * part;
    used.largest = std::max(used.largest, std::abs(part));
    if (outside(used, x[t])) flag = 1.0;
  }
  sd = std::sqrt(variance_of(work, x, y, slope) + work.staying_variance);
}

Counts take_all(const Inputs& known, Work& work, Channel& channel, Channel& sd, Channel& flags) {
  Counts counts;
  std::vector<Felt> felt(block);
  std::vector<double> x(work.terms.size());
  for (std::size_t first = 0; first < channel.values.size(); first += block) {
    const std::size_t size = std::min(block, channel.values.size() - first);
    known.fill(first, std::span(felt).first(size));
    for (std::size_t i = first; i < first + size; ++i) {
      const bool measured = !std::isnan(channel.values[i]);
      const bool known_all = !std::isnan(errors_at(work, felt[i - first], channel.values[i])) || !measured;
      take_sample(work, felt[i - first], channel.values[i], sd.values[i], flags.values[i], x);
      counts.blank += measured && !known_all;
      counts.lost += measured && known_all && std::isnan(channel.values[i]);
      if (std::isnan(channel.values[i])) continue;
      ++counts.samples;
      if (flags.values[i] > 0.0 && counts.outside++ == 0) counts.first_outside = channel.time(i);
    }
  }
  return counts;
}

std::string joined(const std::set<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

void say_staying(const Work& work, const std::string& channel, Findings& findings) {
  std::map<std::set<std::string>, std::set<std::string>> terms;  // by what is missing
  for (const auto& used : work.staying) {
    std::set<std::string> names;
    for (const std::size_t k : used.missing) names.insert(inputs()[k].name);
    terms[names].insert(used.term.name);
  }
  for (const auto& [missing, names] : terms)
    findings.push_back(
        {Finding::Severity::warning,
         fmt::format("neither a channel nor a plan says {}: {} cannot be subtracted and remains in the output; channel "
                     "{}.compensation_sd counts it with the range that the calibration covered. Name the channel in "
                     "[channels], or give the plan by --plan",
                     joined(missing), joined(names), channel),
         channel});
}

void say(const Counts& counts, const std::string& channel, Findings& findings) {
  const auto add = [&](std::string text) {
    findings.push_back({Finding::Severity::warning, std::move(text), channel});
  };
  if (counts.outside > 0)
    add(
        fmt::format("{:.2g} % of the samples lie outside of what the calibration covered, the first at {:.6g} s: the "
                    "compensation is extrapolated there and its stated uncertainty does not hold; channel "
                    "{}.extrapolated marks them",
                    100.0 * static_cast<double>(counts.outside) / static_cast<double>(counts.samples),
                    counts.first_outside, channel));
  if (counts.blank > 0)
    add(fmt::format("{} samples lack an input of the error model: they could not be compensated and are missing now",
                    counts.blank));
  if (counts.lost > 0)
    add(
        fmt::format("in {} samples the error changes by more than half of what is measured: the error model does not "
                    "hold there, and they are missing now",
                    counts.lost));
}

Table subtracted(const Work& work, const Counts& counts, const Unit& unit) {
  Table table{"subtracted",
              "what each term of the error model gave over the recording",
              {{"term", Unit()}, {"mean", unit}, {"sd", unit}, {"largest", unit}, {"inputs", Unit()}},
              {}};
  const double n = std::max(1.0, static_cast<double>(counts.samples));
  for (const auto& used : work.terms) {
    const double mean = used.sum / n;
    table.rows.push_back({used.term.name, mean, std::sqrt(std::max(0.0, used.squares / n - mean * mean)), used.largest,
                          joined(used.from)});
  }
  for (const auto& used : work.staying)
    table.rows.push_back({used.term.name, std::nan(""), std::nan(""), std::nan(""), std::string("missing: remains")});
  return table;
}

std::size_t place_of(const Estimate& estimate, const Recording& recording, const std::string& role) {
  const Channel* channel = channel_of(estimate, recording, role);
  const std::string where = recording.origin.file.empty() ? "" : recording.origin.file + ": ";
  if (!channel) throw Error(Error::Kind::bad_data, where + "the recording has no channel for the role " + role);
  if (find_channel(recording, channel->name + ".compensation_sd"))
    throw Error(Error::Kind::bad_data,
                where + "channel " + channel->name + " is compensated already: it would be subtracted twice");
  return static_cast<std::size_t>(channel - recording.channels.data());
}

}  // namespace

Settings settings_of(const Estimate& estimate, const std::vector<Option>& options) {
  std::vector<Given> given;
  std::vector<std::string> problems;
  for (const auto& option : options)
    if (const auto text = estimate.provenance.settings.find(option.name);
        text != estimate.provenance.settings.end() && !text->second.empty())
      given.push_back({option.name, text->second, "the result's provenance", true, true});
  Settings settings = resolve(options, given, "method " + estimate.method, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
  return settings;
}

const Channel* channel_of(const Estimate& estimate, const Recording& recording, const std::string& role) {
  const auto given = estimate.provenance.settings.find("channels." + role);
  return find_channel(recording, given == estimate.provenance.settings.end() ? role : given->second);
}

Table regressors_table(const std::vector<Term>& terms, const std::vector<double>& least,
                       const std::vector<double>& greatest) {
  Table table{regressors_name,
              "range of each term's regressor over the data used [SI]: what the result may be used for",
              {{"parameter", Unit()}, {"least", Unit()}, {"greatest", Unit()}},
              {},
              true};
  for (std::size_t j = 0; j < terms.size(); ++j) table.rows.push_back({terms[j].name, least[j], greatest[j]});
  return table;
}

Compensation compensate(const ErrorModel& model, const Estimate& estimate, const Recording& recording,
                        const Plan* plan) {
  Work work{&model, &estimate, {}, {}};
  set_scale_factor(work);
  auto terms = used_terms(model, estimate);
  const std::size_t place = place_of(estimate, recording, model.role);
  const Channel& raw = recording.channels[place];
  const Inputs known = compensation::inputs_of(estimate, recording, raw, plan);
  sort_terms(known, std::move(terms), work);

  Compensation out{recording, {}, {}};
  Channel& channel = out.recording.channels[place];
  channel.unit = Unit::parse(model.unit);
  channel.kind = kind_of(channel.unit);
  Channel sd = channel, flags = channel;
  sd.name += ".compensation_sd";
  flags.name += ".extrapolated";
  flags.kind = QuantityKind::other;
  flags.unit = Unit();
  const Counts counts = take_all(known, work, channel, sd, flags);
  say_staying(work, channel.name, out.findings);
  say(counts, channel.name, out.findings);
  out.tables.push_back(subtracted(work, counts, channel.unit));
  out.recording.channels.push_back(std::move(sd));
  out.recording.channels.push_back(std::move(flags));
  return out;
}

}  // namespace tumble
