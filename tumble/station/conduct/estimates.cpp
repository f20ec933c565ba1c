#include "tumble/station/conduct/estimates.hpp"

#include <algorithm>

#include "tumble/units/nearest.hpp"

namespace tumble::conduct {
namespace {

constexpr double first_look = 10.0;    ///< [s] of a segment without a rule
constexpr double least_between = 1.0;  ///< [s] between two estimates
/// Of the time that was recorded: a segment ends at most so much later than it might. The answers of one segment are
/// a geometric series, so that they cost no more than twenty times the last one.
constexpr double growth = 0.05;

/// Why the rule cannot be judged by this estimate; empty: it can.
Sentence misfit(const StoppingRule& rule, const Estimate& estimate) {
  std::vector<std::string> names;
  for (const Parameter& parameter : estimate.parameters) names.push_back(parameter.name);
  const Parameter* const parameter = find_parameter(estimate, rule.parameter);
  if (!parameter)
    return say("the estimate so far has no parameter '{}'{}", rule.parameter, did_you_mean(rule.parameter, names));
  if (parameter->unit.dimension() != rule.unit.dimension())
    return say("'{}' is given in {}, and {} in {}", rule.text, Name{rule.unit.text()}, Name{rule.parameter},
               Name{parameter->unit.text()});
  return {};
}

}  // namespace

const StoppingRule* Estimates::rule() const {
  const auto found = course_.until.find(label_);
  return found == course_.until.end() ? nullptr : &found->second;
}

std::string Estimates::slot_of(const LiveEstimates::Answer& answer) const {
  return answer.slot.empty() && course_.units.size() == 1 ? course_.units.front().slot : answer.slot;
}

void Estimates::begin(const std::string& label, double time) {
  label_ = label;
  began_ = time;
  next_ = time + (rule() ? rule()->at_least : first_look);
  noted_ = false;
}

void Estimates::journal(double time, const RunRow& row) const {
  if (live_) live_->journal(time, row);
}

void Estimates::look(double now, bool recording, const std::function<void(EstimateNow)>& tell,
                     const std::function<void(const Note&)>& note) {
  if (!live_) return;
  if (recording && now >= next_ && live_->begin(now)) next_ = now + std::max(least_between, growth * (now - began_));
  for (const auto& answer : live_->finished()) take(answer, tell, note);
}

void Estimates::take(const LiveEstimates::Answer& answer, const std::function<void(EstimateNow)>& tell,
                     const std::function<void(const Note&)>& note) {
  if (answer.estimate) answers_[slot_of(answer)] = answer;
  // An answer that began before the least time of this segment does not hold its samples.
  if (!rule() || answer.time < began_ + rule()->at_least) return;
  const Sentence problem = answer.estimate ? misfit(*rule(), *answer.estimate) : answer.problem;
  if (!problem.empty()) {
    if (!noted_) note({EventKind::estimate, say("'{}' cannot be judged yet: {}", rule()->text, problem)});
    noted_ = true;
    return;
  }
  const auto& all = answer.estimate->parameters;
  const auto index = static_cast<std::size_t>(find_parameter(*answer.estimate, rule()->parameter) - all.data());
  tell({slot_of(answer), rule()->parameter, all[index].value, standard_uncertainty(*answer.estimate, index)});
}

std::vector<RunView::EstimateView> Estimates::view() const {
  std::vector<RunView::EstimateView> view;
  for (const auto& [slot, answer] : answers_)
    for (std::size_t i = 0; i < answer.estimate->parameters.size(); ++i) {
      const Parameter& parameter = answer.estimate->parameters[i];
      view.push_back(
          {slot, parameter.name, parameter.unit, parameter.value, standard_uncertainty(*answer.estimate, i)});
    }
  return view;
}

}  // namespace tumble::conduct
