#include "tumble/reduce/compensate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tumble/core/roles.hpp"
#include "tumble/core/sampling_rate.hpp"
#include "tumble/reduce/compensation/inputs.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/reduce/compensation/work.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using compensation::input_count;
using compensation::Inputs;
using compensation::inputs;
using compensation::UsedTerm;
using compensation::Work;

constexpr std::size_t block = 4096;           ///< samples
constexpr double tolerance = 1e-12;           ///< of the size of u
constexpr double settled_within = 1e-10;      ///< of outputs together: each is solved to `tolerance` only
constexpr double greatest_error_slope = 0.5;  ///< dE/du beyond which the model is no model of errors
constexpr int most_steps = 30, most_passes = 30;

using Works = std::vector<Work>;

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
      limits[*name] = {compensation::number_in(*table, row[1]), compensation::number_in(*table, row[2])};
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
    if (!term.unit.empty() && estimate.parameters[p].unit.dimension() != Unit::parse(term.unit).dimension())
      faults.push_back(fmt::format("the result's parameter '{}' is in {}, but must be in {} or the like", term.name,
                                   estimate.parameters[p].unit.text(), term.unit));
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

/// The output that shows an input; the number of outputs where none does.
std::size_t shown_by(const Works& works, std::size_t input) {
  Felt felt;
  const auto match = std::ranges::find_if(
      works, [&](const Work& work) { return &inputs()[input].of(felt) == &work.model->shown(felt); });
  return static_cast<std::size_t>(match - works.begin());
}

/// Terms whose inputs are all known, and the others.
void sort_terms(const Inputs& known, const Works& works, const Recording& recording, std::vector<UsedTerm> terms,
                Work& work) {
  for (auto& used : terms) {
    const auto needed = compensation::needs(used.term);
    for (std::size_t k = 0; k < input_count; ++k) {
      if (!needed[k]) continue;
      if (const std::size_t by = shown_by(works, k); by < works.size()) {
        const bool itself = &works[by] == &work;
        used.from.insert(itself ? "the channel itself" : "channel " + recording.channels[works[by].place].name);
        if (!itself && std::ranges::find(work.others, by) == work.others.end()) work.others.push_back(by);
      } else if (known.from[k].empty()) {
        used.missing.push_back(k);
      } else {
        used.from.insert(known.from[k]);
      }
    }
    const double middle = 0.5 * (used.least + used.greatest), width = used.greatest - used.least;
    if (!used.missing.empty())
      work.staying_variance +=
          (used.coefficient * used.coefficient + work.estimate->covariance(used.parameter, used.parameter)) *
          (middle * middle + width * width / 12.0);
    (used.missing.empty() ? work.terms : work.staying).push_back(std::move(used));
  }
}

/// Index and value of a parameter that the model cannot do without. Nothing where it names none.
void set_parameter(const Estimate& estimate, const std::string& name, std::size_t& index, double& value) {
  if (name.empty()) return;
  index = index_of(estimate, name);
  if (index == estimate.parameters.size())
    throw Error(Error::Kind::bad_file, say("the result has no parameter {}", name));
  value = estimate.parameters[index].value;
  if (!std::isfinite(value)) throw Error(Error::Kind::bad_file, say("the result's parameter '{}' has no value", name));
}

void set_parameters(Work& work) {
  const ErrorModel& model = *work.model;
  set_parameter(*work.estimate, model.scale_factor, work.scale_parameter, work.scale_factor);
  if (work.scale_factor == 0.0)
    throw Error(Error::Kind::bad_file, say("the result's parameter '{}' has no value", model.scale_factor));
  set_parameter(*work.estimate, model.offset, work.offset_parameter, work.offset);
  if (const Parameter* spread = find_parameter(*work.estimate, model.spread))
    work.spread_variance = spread->value * spread->value;
}

double errors_at(const Work& work, const Felt& felt) {
  double sum = 0.0;
  for (const auto& used : work.terms) sum += used.coefficient * used.term.regressor(felt);
  return sum;
}

double errors_at(const Work& work, Felt& felt, double u) {
  work.model->shown(felt) = u;
  return errors_at(work, felt);
}

/// dE/du by the difference over a small step to both sides; u may be that of another output.
double error_slope(const Work& work, const ErrorModel& by, Felt& felt, double u) {
  const double step = 1e-4 * std::max(std::abs(u), 1e-6);
  by.shown(felt) = u + step;
  const double above = errors_at(work, felt);
  by.shown(felt) = u - step;
  const double below = errors_at(work, felt);
  by.shown(felt) = u;
  return (above - below) / (2.0 * step);
}

/// u and dE/du there; NaN where there is no root of which the model is sure.
void solve(Work& work, Felt& felt) {
  const double y = work.y;
  if (work.model->by_output) {
    work.u = y - errors_at(work, felt);
    return;
  }
  double u = y;
  for (int n = 0; n < most_steps; ++n) {
    const double slope = error_slope(work, *work.model, felt, u), g = u + errors_at(work, felt, u) - y;
    if (!(std::abs(slope) < greatest_error_slope)) break;
    if (std::abs(g) <= (1.0 - std::abs(slope)) * tolerance * std::max(std::abs(u), std::abs(y))) {
      work.u = u, work.slope = slope;
      return;
    }
    u -= g / (1.0 + slope);
  }
  work.u = work.model->shown(felt) = std::nan("");
}

/// One output after the other, each with what the others show by now, until nothing changes.
void solve_together(Works& works, Felt& felt) {
  for (int pass = 0; pass < most_passes; ++pass) {
    bool settled = true;
    for (Work& work : works) {
      const double before = work.u;
      solve(work, felt);
      const bool blank = std::isnan(work.u) && std::isnan(before);
      settled = settled && (work.others.empty() || work.model->by_output || blank ||
                            std::abs(work.u - before) <= settled_within * std::max(std::abs(work.u), std::abs(work.y)));
    }
    if (settled) return;
  }
  for (Work& work : works)
    if (!work.others.empty()) work.u = std::nan("");
}

/// Derivatives of u by all parameters, those of the outputs that it depends on with them (their own dependence on each
/// other is of second order), and the variance of what stays in.
double variance_of(const Works& works, const Work& work, Felt& felt) {
  auto d = work.d;
  double staying = work.staying_variance;
  for (const std::size_t other : work.others) {
    if (work.model->by_output) break;
    const Work& by = works[other];
    const double share = -error_slope(work, *by.model, felt, by.u) / (1.0 + work.slope);
    for (const auto& [parameter, derivative] : by.d) d.emplace_back(parameter, share * derivative);
    staying += share * share * by.staying_variance;
  }
  double sum = 0.0;
  for (const auto& [i, a] : d)
    for (const auto& [j, b] : d) sum += a * b * work.estimate->covariance(i, j);
  return (sum < 0.0 ? 0.0 : sum) + staying + work.spread_variance;  // what is no number stays so
}

bool outside(const UsedTerm& used, double x) {
  const double slack =
      0.02 * (used.greatest - used.least) + 1e-6 * std::max(std::abs(used.least), std::abs(used.greatest));
  return x < used.least - slack || x > used.greatest + slack;
}

/// The terms at the solution: their sizes, u's derivatives, whether the calibration covered them (false).
bool take_terms(Work& work, const Felt& felt) {
  bool far = false;
  work.d.clear();
  for (UsedTerm& used : work.terms) {
    const double x = used.term.regressor(felt), part = used.coefficient * x;
    used.sum += part;
    used.squares += part * part;
    used.largest = std::max(used.largest, std::abs(part));
    work.d.emplace_back(used.parameter, -x / (1.0 + work.slope));
    far = far || outside(used, x);
  }
  if (work.scale_parameter != SIZE_MAX)
    work.d.emplace_back(work.scale_parameter, -work.y / work.scale_factor / (1.0 + work.slope));
  if (work.offset_parameter != SIZE_MAX)
    work.d.emplace_back(work.offset_parameter, -1.0 / work.scale_factor / (1.0 + work.slope));
  return far;
}

/// One sample of all outputs: u in place of each, its uncertainty, and whether the calibration covered it.
void take_sample(Works& works, Felt& felt, std::size_t i, Recording& recording) {
  for (Work& work : works) {
    const double value = recording.channels[work.place].values[i];
    work.y = work.u = (value * work.model->scale - work.offset) / work.scale_factor;
    work.model->shown(felt) = work.y;
  }
  std::vector<bool> informed;
  for (const Work& work : works) informed.push_back(!std::isnan(errors_at(work, felt)));
  solve_together(works, felt);
  for (std::size_t k = 0; k < works.size(); ++k) {
    Work& work = works[k];
    const bool measured = !std::isnan(work.y), solved = !std::isnan(work.u);
    work.counts.blank += measured && !informed[k];
    work.counts.lost += measured && informed[k] && !solved;
    recording.channels[work.place].values[i] = work.u;
    work.trust.extrapolated.values[i] = !solved ? std::nan("") : take_terms(work, felt) ? 1.0 : 0.0;
    if (!solved) work.d.clear();
    work.counts.samples += solved;
    if (work.trust.extrapolated.values[i] > 0.0 && work.counts.outside++ == 0)
      work.counts.first_outside = work.trust.sd.time(i);
  }
  for (Work& work : works)
    work.trust.sd.values[i] = std::isnan(work.u) ? work.u : std::sqrt(variance_of(works, work, felt));
}

void take_all(const Inputs& known, Works& works, Recording& recording) {
  const std::size_t samples = recording.channels[works.front().place].values.size();
  std::vector<Felt> felt(block);
  for (std::size_t first = 0; first < samples; first += block) {
    const std::size_t size = std::min(block, samples - first);
    known.fill(first, std::span(felt).first(size));
    for (std::size_t i = 0; i < size; ++i) take_sample(works, felt[i], first + i, recording);
  }
}

/// Whether the channel is in the unit of K times u: as it is, or for each sample (counts, increments).
void add_unit_problem(const Work& work, const Channel& channel, Problems& problems) {
  if (work.scale_parameter == SIZE_MAX) {
    if (work.model->scale == 1.0) compensation::require_dimension(&channel, work.model->unit, problems);
    return;
  }
  const Unit& factor = work.estimate->parameters[work.scale_parameter].unit;
  const auto wanted = Unit::parse(fmt::format("({})*({})", factor.text(), work.model->unit)).dimension();
  const auto each_second = Unit::parse(fmt::format("({})/s", channel.unit.text())).dimension();
  if (channel.unit.dimension() == wanted || each_second == wanted) return;
  problems.push_back(
      say("channel {} is in {}, but the result's {} is in {}: the recording is of another kind of output", channel.name,
          channel.unit.text(), work.model->scale_factor, factor.text()));
}

/// The channels of all outputs, sampled together. Throws Error::bad_data with all that is wrong.
void set_places(const Recording& recording, Works& works) {
  Problems problems;
  for (Work& work : works) {
    const auto place = compensation::output_of(*work.estimate, recording, work.model->role, problems);
    if (!place) continue;
    work.place = *place;
    const Channel &first = recording.channels[works.front().place], &channel = recording.channels[work.place];
    add_unit_problem(work, channel, problems);
    if (problems.empty() && !sampled_together(first, channel))
      problems.push_back(
          say("channels {} and {} are not sampled together: bring them to one clock first", first.name, channel.name));
  }
  compensation::refuse(recording, problems);
}

void set_channels(Recording& recording, Work& work) {
  Channel& channel = recording.channels[work.place];
  channel.unit = Unit::parse(work.model->unit);
  channel.kind = kind_of(channel.unit);
  work.trust = compensation::trust_in(channel);
}

}  // namespace

Settings settings_of(const Estimate& estimate, const std::vector<Option>& options) {
  std::vector<Given> given;
  Problems problems;
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
  const auto names = names_of_role(role);
  const bool by_role =
      given == estimate.provenance.settings.end() || std::ranges::find(names, given->second) != names.end();
  return by_role ? find_role(recording, role) : find_channel(recording, given->second);
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

Compensation compensate(const std::vector<ErrorModel>& models, const Estimate& estimate, const Recording& recording,
                        const Plan* plan) {
  Works works;
  std::vector<std::vector<UsedTerm>> terms;
  for (const ErrorModel& model : models) {
    Work& work = works.emplace_back();
    work.model = &model;
    work.estimate = &estimate;
    set_parameters(work);
    terms.push_back(used_terms(model, estimate));
  }
  set_places(recording, works);
  const Inputs known = compensation::inputs_of(estimate, recording, recording.channels[works.front().place], plan);
  for (std::size_t k = 0; k < works.size(); ++k) sort_terms(known, works, recording, std::move(terms[k]), works[k]);

  Compensation out{recording, {}, {}};
  for (Work& work : works) set_channels(out.recording, work);
  take_all(known, works, out.recording);
  for (Work& work : works) {
    const Channel& channel = out.recording.channels[work.place];
    say_staying(work, channel.name, out.findings);
    say(work.counts, channel.name, out.findings);
    out.tables.push_back(
        subtracted(work, works.size() > 1 ? "subtracted_" + work.model->role : "subtracted", channel.unit));
    out.recording.channels.push_back(std::move(work.trust.sd));
    out.recording.channels.push_back(std::move(work.trust.extrapolated));
  }
  return out;
}

Compensation compensate(const ErrorModel& model, const Estimate& estimate, const Recording& recording,
                        const Plan* plan) {
  return compensate(std::vector<ErrorModel>{model}, estimate, recording, plan);
}

}  // namespace tumble
