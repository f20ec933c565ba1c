#include "tumble/station/testing/executive_bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::testing {
namespace {

using Kind = BenchFault::Kind;

const std::set<ControllerVerb> harmless{ControllerVerb::stop,   ControllerVerb::hold,  ControllerVerb::off,
                                        ControllerVerb::read,   ControllerVerb::state, ControllerVerb::disable,
                                        ControllerVerb::release};

double towards(double from, double to, double most) {
  return std::abs(to - from) <= most ? to : from + std::copysign(most, to - from);
}

}  // namespace

ExecutiveBench::ExecutiveBench(std::shared_ptr<const Course> course, std::optional<ExecutiveState> begin)
    : state(begin ? std::move(*begin) : start_state(course)), course_(course), axes_(course->station.axes.size()) {
  at(0.0, RunOrder{RunOrder::Kind::start, "operator"});
}

void ExecutiveBench::fault(BenchFault fault) {
  if (fault.kind == Kind::cut) {
    at(fault.from, LinkLost{fault.device, "connection reset"});
    if (std::isfinite(fault.until)) at(fault.until, LinkUp{fault.device});
  }
  faults_.push_back(std::move(fault));
}

void ExecutiveBench::at(double time, decltype(RunEvent::what) what) { events_.push({time, order_++, std::move(what)}); }

const BenchFault* ExecutiveBench::fault_of(Kind kind, const std::string& device, double time) const {
  for (const auto& fault : faults_)
    if (fault.kind == kind && fault.device == device && time >= fault.from && time < fault.until) return &fault;
  return nullptr;
}

std::optional<RunEnding> ExecutiveBench::run(double until) {
  while (!ended) {
    const double next = events_.empty() ? std::numeric_limits<double>::infinity() : events_.top().time;
    const double time = std::min(next, wake_.value_or(std::numeric_limits<double>::infinity()));
    if (!(time <= until)) break;
    if (next <= time) {
      const Scheduled event = events_.top();
      events_.pop();
      take({event.time, event.what});
    } else {
      wake_.reset();
      take({time, Tick{}});
    }
  }
  return ended ? std::optional(ended->ending) : std::nullopt;
}

void ExecutiveBench::sleep(double until) {
  std::vector<Scheduled> arrived;
  for (; !events_.empty() && events_.top().time <= until; events_.pop()) arrived.push_back(events_.top());
  wake_.reset();
  for (std::size_t i = 0; i < arrived.size(); ++i) take({until, arrived[i].what, i + 1 < arrived.size()});
  if (arrived.empty()) take({until, Tick{}});
}

void ExecutiveBench::take(const RunEvent& event) {
  move(event.time);
  std::vector<RunAction> actions;
  const RunPhase before = state.phase;
  state = step(std::move(state), event, actions);
  ++steps;
  perform(actions, before);
}

void ExecutiveBench::perform(const std::vector<RunAction>& actions, RunPhase phase) {
  for (const auto& action : actions) {
    if (const auto* note = std::get_if<Note>(&action)) {
      notes.push_back(*note);
      if (note->kind != EventKind::phase) continue;
      const RunPhase to = note->phase.value();
      if (note->text.text() != fmt::format("{} -> {}", name(phase), name(to)) || !may_follow(phase, to))
        faults_of_order.push_back(note->text);
      phase = to;
      phase_began.try_emplace(std::string(name(to)), now_);
    } else if (const auto* row = std::get_if<JournalEntry>(&action)) {
      rows.push_back(row->row);
    } else if (const auto* wanted = std::get_if<WakeAt>(&action)) {
      wake_ = std::max(wanted->time, now_);
    } else if (const auto* prompt = std::get_if<Prompt>(&action)) {
      prompts.push_back(*prompt);
      if (const auto answer = answering ? answering(*prompt) : std::nullopt)
        at(now_ + answer->first, PromptAnswer{prompt->id, answer->second, "operator"});
    } else if (const auto* record = std::get_if<RecordSwitch>(&action)) {
      if (record->on)
        recorded.push_back({now_, -1.0, *record});
      else
        recorded.back().end = now_;
    } else if (const auto* end = std::get_if<RunEnd>(&action)) {
      ended = *end;
      ended_at = now_;
    } else if (const auto* ask = std::get_if<Ask>(&action)) {
      asked.push_back({now_, *ask, state.phase});
      safe_began_ = safe_began_ || ask->urgent;
      if (safe_began_ && !harmless.contains(ask->request.verb)) faults_of_order.push_back(name(ask->request.verb));
      carry_out(*ask);
    }
  }
}

void ExecutiveBench::carry_out(const Ask& ask) {
  const bool gone = fault_of(Kind::silent, ask.device, now_) || fault_of(Kind::cut, ask.device, now_);
  if (gone) return;
  ControllerReply reply = reply_to(ask);
  const auto* lost = fault_of(Kind::deaf_reply, ask.device, now_);
  if (lost && (!lost->verb || lost->verb == ask.request.verb)) return;
  if (fault_of(Kind::wrong_reply, ask.device, now_)) reply.verb = ControllerVerb::identify;
  at(now_ + reply_after, DeviceReply{ask.device, reply});
}

void ExecutiveBench::command(Physical& axis, const StationAxis& setup, const ControllerRequest& request) {
  using Mode = Physical::Mode;
  const auto value = [&](const char* name) { return request.values.at(name); };
  if (request.verb == ControllerVerb::position) {
    axis.mode = Mode::position;
    axis.target = setup.sign * value("position") + setup.offset;
    axis.speed = request.values.contains("rate") ? value("rate") : 1.0;
  } else if (request.verb == ControllerVerb::rate) {
    axis.mode = Mode::rate;
    axis.target = setup.sign * value("rate");
  } else if (request.verb == ControllerVerb::sine) {
    axis.mode = Mode::sine;
    axis.target = value("frequency");
  } else if (request.verb == ControllerVerb::set_temperature) {
    axis.set_point = setup.sign * value("temperature") + setup.offset;
  } else if (request.verb == ControllerVerb::stop) {
    axis.mode = Mode::rest;
  }
}

ControllerReply ExecutiveBench::reply_to(const Ask& ask) {
  ControllerReply reply{ask.request.verb};
  reply.axis = ask.request.axis;
  const auto* refusal = fault_of(Kind::refuses, ask.device, now_);
  if (refusal && refusal->verb == ask.request.verb) {
    reply.refused = true;
    reply.text = "not now";
    return reply;
  }
  if (reply.verb == ControllerVerb::identify) reply.words["identity"] = "BENCH " + ask.device + " SN 7";
  if (reply.verb == ControllerVerb::state) reply.values["motion"] = 0.0;
  if (reply.verb == ControllerVerb::state)
    reply.words["state"] = fault_of(Kind::alarm, ask.device, now_) ? "alarm" : "ready";
  const bool stuck = fault_of(Kind::stuck, ask.device, now_) || fault_of(Kind::ignores, ask.device, now_);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto& setup = course_->station.axes[i];
    if (course_->station.devices[setup.device].name != ask.device || setup.number != ask.request.axis) continue;
    if (!stuck) command(axes_[i], setup, ask.request);
    if (reply.verb == ControllerVerb::set_point)
      reply.values["set_point"] = setup.sign * (axes_[i].set_point - setup.offset);
    if (reply.verb != ControllerVerb::read) continue;
    const auto* noise = fault_of(Kind::noise, ask.device, now_);
    const double error = noise ? (++readings_ % 2 ? noise->size : -noise->size) : 0.0;
    if (setup.kind == StationAxis::Kind::temperature) {
      reply.values["temperature"] = setup.sign * (axes_[i].temperature - setup.offset);
    } else {
      const double position = setup.sign * (axes_[i].position - setup.offset) + error;
      reply.values["position"] = resolution > 0.0 ? resolution * std::round(position / resolution) : position;
      if (reads_rate) reply.values["rate"] = setup.sign * axes_[i].rate + error;
    }
  }
  return reply;
}

void ExecutiveBench::move(double to) {
  constexpr double acceleration = 2.0, standard_ramp = 0.5;  // [rad/s^2, K/s]
  const double dt = to - now_;
  now_ = std::max(now_, to);
  if (!(dt > 0.0)) return;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    auto& axis = axes_[i];
    const auto& device = course_->station.devices[course_->station.axes[i].device].name;
    const auto* off = fault_of(Kind::off_rate, device, now_);
    const auto* slow = fault_of(Kind::slow, device, now_);
    axis.temperature = towards(axis.temperature, axis.set_point, (slow ? slow->size : standard_ramp) * dt);
    if (axis.mode == Physical::Mode::position) {
      const double before = axis.position;
      axis.position = towards(before, axis.target, axis.speed * dt);
      axis.rate = (axis.position - before) / dt;
    } else if (axis.mode == Physical::Mode::sine) {
      axis.rate = std::cos(two_pi * axis.target * now_);
    } else {
      const double wanted = axis.mode == Physical::Mode::rate ? axis.target * (1.0 + (off ? off->size : 0.0)) : 0.0;
      axis.rate = towards(axis.rate, wanted, acceleration * dt);
      axis.position += axis.rate * dt;
    }
  }
}

double ExecutiveBench::true_rate(const std::string& axis) const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (course_->station.axes[i].name == axis) return axes_[i].rate;
  return 0.0;
}

double ExecutiveBench::true_position(const std::string& axis) const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (course_->station.axes[i].name == axis) return axes_[i].position;
  return 0.0;
}

Station bench_station(bool supply) {
  Station station;
  station.name = "bench";
  const std::vector<ControllerVerb> table{ControllerVerb::identify, ControllerVerb::take, ControllerVerb::enable,
                                          ControllerVerb::position, ControllerVerb::rate, ControllerVerb::sine,
                                          ControllerVerb::stop,     ControllerVerb::read, ControllerVerb::state,
                                          ControllerVerb::release};
  const std::vector<ControllerVerb> chamber{
      ControllerVerb::identify, ControllerVerb::start, ControllerVerb::set_temperature,
      ControllerVerb::read,     ControllerVerb::state, ControllerVerb::hold,
      ControllerVerb::off};
  station.devices.push_back({.name = "servo",
                             .link = "tcp:host:1",
                             .poll = 0.1,
                             .timeout = 0.25,
                             .lost_after = 0.5,
                             .identity = "SN 7",
                             .verbs = table,
                             .once = {ControllerVerb::enable},
                             .prepare = {ControllerVerb::identify, ControllerVerb::take, ControllerVerb::enable},
                             .finish = {ControllerVerb::release}});
  station.devices.push_back({.name = "climate",
                             .link = "tcp:host:2",
                             .poll = 1.0,
                             .timeout = 2.0,
                             .lost_after = 10.0,
                             .verbs = chamber,
                             .prepare = {ControllerVerb::identify, ControllerVerb::start}});
  StationAxis axis{.name = "table", .sign = -1, .offset = 0.3, .turns = StationAxis::Turns::counted};
  axis.settle = {.value = si(0.01, "deg"), .rate = si(0.01, "deg/s"), .hold = 1.0, .timeout = 30.0};
  station.axes.push_back(axis);
  StationAxis oven{.name = "chamber", .device = 1, .kind = StationAxis::Kind::temperature};
  oven.settle = {.value = 0.5, .rate = si(0.5, "K/min"), .hold = 30.0, .timeout = 900.0, .soak = 60.0};
  station.axes.push_back(oven);
  station.safe.push_back({.device = 0, .request = {ControllerVerb::stop}, .within = 5.0});
  station.safe.push_back({.device = 1, .request = {ControllerVerb::hold}, .within = 15.0});
  if (supply) {
    station.devices.push_back({.name = "supply",
                               .link = "tcp:host:3",
                               .poll = 1.0,
                               .timeout = 1.0,
                               .lost_after = 5.0,
                               .verbs = {ControllerVerb::start, ControllerVerb::off, ControllerVerb::read}});
    station.power.device = 2;
    station.safe.push_back({.device = 2, .request = {ControllerVerb::off}, .within = 5.0, .wait = true});
  }
  return station;
}

Segment bench_segment(const std::string& label, double duration, std::map<std::string, Motion> axes, int run) {
  return {label, duration, run, std::move(axes)};
}

std::shared_ptr<const Course> bench_course(Schedule schedule, Station station) {
  return std::make_shared<const Course>(Course{.station = std::move(station), .schedule = std::move(schedule)});
}

Schedule table_schedule() {
  return {bench_segment("rest", 10.0, {{"table", hold_at(0.0)}}),
          bench_segment("forwards", 10.0, {{"table", turn_at(20.0)}}),
          bench_segment("backwards", 10.0, {{"table", turn_at(-20.0)}}),
          bench_segment("90 deg", 10.0, {{"table", hold_at(90.0)}})};
}

Motion hold_at(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion turn_at(double degrees_per_second) {
  return {.kind = Motion::Kind::rate, .value = si(degrees_per_second, "deg/s")};
}
Motion warm_to(double celsius) { return {.kind = Motion::Kind::dwell, .value = si(celsius, "degC")}; }

std::vector<RunRow> rows_of_kind(const ExecutiveBench& bench, RunRow::Kind kind) {
  std::vector<RunRow> rows;
  for (const auto& row : bench.rows)
    if (row.kind == kind) rows.push_back(row);
  return rows;
}

std::vector<ExecutiveBench::Asked> asked_for(const ExecutiveBench& bench, ControllerVerb verb) {
  std::vector<ExecutiveBench::Asked> asked;
  for (const auto& one : bench.asked)
    if (one.ask.request.verb == verb) asked.push_back(one);
  return asked;
}

}  // namespace tumble::testing
