#include "tumble/tasks/optimisation/work.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/language/say.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble::optimisation {
namespace {

using namespace prediction;

constexpr std::size_t first_look = 120;  ///< candidates, evenly taken, that say which terms can be shown at all

Estimate evaluate(const Work& work, const Plan& plan) {
  if (!work.from_terms) return predict(plan);
  return predict_model(plan, work.only, false);
}

/// The schedule in every power-up.
Schedule in_all_runs(const Schedule& one, const std::vector<int>& runs) {
  Schedule out;
  for (const int run : runs)
    for (auto segment : one) {
      segment.run = run;
      out.push_back(std::move(segment));
    }
  return out;
}

}  // namespace

Plan with_schedule(const Plan& plan, Schedule schedule) {
  Plan out = plan;
  out.schedule = std::move(schedule);
  return out;
}

double total_of(const Schedule& schedule) {
  double sum = 0.0;
  for (const auto& segment : schedule) sum += segment.duration;
  return sum;
}

bool is_quick(const Work& work) { return work.from_terms || find_method(work.plan.method).predict; }

Schedule fitted(const Work& work, Visits visits) {
  if (work.closing && visits.size() > 1) {
    visits.front().dwell *= 0.5;
    visits.push_back(visits.front());
  }
  const double interval = 1.0 / work.plan.sample_rate;
  Schedule schedule;
  for (int pass = 0; pass < 4; ++pass) {
    schedule = schedule_of(work.plan, work.all, visits, work.settling);
    const double dwell = std::accumulate(visits.begin(), visits.end(), 0.0,
                                         [](double sum, const auto& visit) { return sum + visit.dwell; });
    const double wanted = dwell + work.time - total_of(schedule);
    if (std::abs(wanted - dwell) < 0.5 * interval) break;
    for (auto& visit : visits)
      visit.dwell =
          std::max({visit.dwell * std::max(wanted, 0.0) / dwell, shortest_dwell, work.all[visit.candidate].least});
  }
  // What rounding to samples left goes to, or comes from, the longest.
  const double most = static_cast<double>(schedule.size()) * interval;
  const double over = std::clamp(std::round((total_of(schedule) - work.time) / interval) * interval, -most, most);
  auto longest = std::ranges::max_element(
      schedule, {}, [](const Segment& segment) { return segment.approach ? 0.0 : segment.duration; });
  if (longest != schedule.end() && longest->duration > 2.0 * over) longest->duration -= over;
  for (auto& segment : schedule)  // whole samples as people write them: 129.39 s and not 129.39000000000001 s
    segment.duration = std::round(segment.duration * work.plan.sample_rate) / work.plan.sample_rate;
  return in_all_runs(schedule, work.runs);
}

bool too_long(const Work& work, const Schedule& schedule) {
  const double each = total_of(schedule) / static_cast<double>(work.runs.size());
  return each > work.time * (1.0 + 1e-9) + static_cast<double>(schedule.size()) / work.plan.sample_rate;
}

ScheduleRow predicted_row(const Work& work, const std::string& name, Schedule schedule) {
  ScheduleRow out{name, std::move(schedule), {}, {}};
  if (const auto refusals = find_rig(work.plan.rig_kind).refusals(out.schedule, work.plan.rig); !refusals.empty()) {
    out.refused = sentence_of(refusals.front());
    return out;
  }
  try {
    out.estimate = evaluate(work, with_schedule(work.plan, out.schedule));
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data && error.kind != Error::Kind::bad_input) throw;
    out.refused = error.problems.empty() ? reason_of(error) : sentence_of(error.problems.front());
  }
  return out;
}

std::optional<Estimate> by_terms(const Work& work, const ScheduleRow& one) {
  if (work.from_terms) return one.estimate;
  Work terms = work;
  terms.from_terms = true, terms.only = work.terms;
  return predicted_row(terms, "", one.schedule).estimate;
}

Schedule own_in_time(const Work& work) {
  Schedule schedule = work.plan.schedule;
  const double share = work.time * static_cast<double>(work.runs.size()) / total_of(schedule);
  if (std::abs(share - 1.0) < 1e-9) return schedule;
  for (auto& segment : schedule)
    segment.duration =
        std::max(1.0, std::round(segment.duration * share * work.plan.sample_rate)) / work.plan.sample_rate;
  return schedule;
}

Plan everything(const Work& work) {
  Visits visits;
  const std::size_t stride = std::max<std::size_t>(1, work.all.size() / first_look);
  for (std::size_t j = 0; j < work.all.size(); ++j)
    if (j % stride == 0 || work.all[j].felt.size() > 1) visits.push_back({j, std::max(100.0, work.all[j].least)});
  return with_schedule(work.plan, schedule_of(work.plan, work.all, visits, work.settling));
}

std::vector<ScheduleRow> usual_rows(const Work& work, const std::vector<StandardSet>& standard) {
  std::vector<ScheduleRow> rows;
  for (const auto& set : standard) {
    Visits visits;
    for (const auto j : set.candidates) visits.push_back({j, work.time / static_cast<double>(set.candidates.size())});
    auto schedule = fitted(work, std::move(visits));
    if (!too_long(work, schedule)) rows.push_back(predicted_row(work, set.name, std::move(schedule)));
  }
  return rows;
}

}  // namespace tumble::optimisation
