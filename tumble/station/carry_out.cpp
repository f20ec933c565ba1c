#include "tumble/station/carry_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "tumble/station/conduct/channel_values.hpp"
#include "tumble/station/conduct/device_line.hpp"
#include "tumble/station/conduct/estimates.hpp"
#include "tumble/station/conduct/event_queue.hpp"
#include "tumble/station/conduct/flood_watch.hpp"
#include "tumble/station/conduct/hearing.hpp"
#include "tumble/station/conduct/instrument_line.hpp"
#include "tumble/station/conduct/record_words.hpp"
#include "tumble/station/conduct/recorders.hpp"
#include "tumble/station/conduct/row_wait.hpp"
#include "tumble/station/conduct/view.hpp"

namespace tumble {
namespace {

using conduct::DeviceLine;
using conduct::InstrumentLine;

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double values_every = 0.1;    ///< [s] channels are told to the executive
constexpr double longest_wait = 1.0;    ///< [s] without a look at orders
constexpr int most_rounds = 10;         ///< of events, without a look at the time
constexpr double longest_round = 0.05;  ///< [s] of all of them
constexpr double row_look = 0.01;       ///< [s] between looks whether a row is on the disk

struct Device {
  DeviceLine line;
  std::size_t link = 0;           ///< of the recorder
  conduct::WordLimit words = {};  ///< that it says without being asked
};

/// One run from begin to end.
class Conductor {
 public:
  Conductor(ExecutiveState state, const StationParts& parts, const Wires& wires, Recorder& recorder,
            const RunCompany& company)
      : state_(std::move(state)),
        wires_(wires),
        recorder_(recorder),
        company_(company),
        estimates_(company.estimates, *state_.course),
        watched_(conduct::watched_channels(state_.course->station)),
        floods_(state_.course->station, parts, longest_wait),
        rows_(company.longest_commit),
        events_of_store_(recorder, company) {
    state_.awaits_rows = std::isfinite(company.longest_commit);
    const Station& station = state_.course->station;
    devices_.reserve(station.devices.size());
    for (std::size_t d = 0; d < station.devices.size(); ++d) {
      const std::size_t link = recorder_.add_link({.name = station.devices[d].name});
      devices_.push_back(
          {DeviceLine(parts.controllers[d], [this, d](std::string_view bytes) { send(d, bytes); }), link});
    }
    begin_ = wires_.now();
    for (std::size_t i = 0; i < station.instruments.size(); ++i) {
      const StationInstrument& instrument = station.instruments[i];
      auto stream = conduct::recorder_of(instrument, parts.streams[i], state_.course->units.size() > 1, recorder,
                                         company.estimates);
      instruments_.emplace_back(instrument, parts.streams[i], std::move(stream),
                                InstrumentLine::Wire{wires_, devices_.size() + i}, begin_);
    }
    next_show_ = next_values_ = begin_;
  }

  RunEnd run() {
    take_orders(wires_.now());  // after a stop that was ordered before, nothing is prepared
    if (state_.phase == RunPhase::idle) take(RunOrder{RunOrder::Kind::start, {}});
    while (!end_) {
      auto events = wires_.wait(std::min(next(), wires_.now() + longest_wait));
      floods_.looked(wires_.now());
      // What came while the disk was slow, or this process had to wait, is no silence of the devices.
      const double until = wires_.now() + longest_round;
      for (int round = 0; !events.empty() && !end_; ++round) {
        take_all(events);
        const bool more = round < most_rounds && wires_.now() < until;
        events = more ? wires_.wait(wires_.now()) : std::vector<LinkEvent>{};
      }
      if (!end_) look_around();
    }
    for (InstrumentLine& instrument : instruments_) instrument.finish();
    for (const Sentence& words : floods_.dropped()) perform(Note{EventKind::flood, words});
    if (company_.over) company_.over();
    recorder_.close(wires_.now(), say("{}", Name{std::string(name(end_->ending))}));
    events_of_store_.tell();
    return *end_;
  }

 private:
  void send(std::size_t device, std::string_view bytes) {
    recorder_.raw(devices_[device].link, StoreDirection::sent, wires_.now(), bytes);
    wires_.send(device, bytes);
  }

  /// [s] when something is due.
  double next() const {
    double due = std::min(state_.wake.value_or(never), next_values_);
    if (rows_.waits()) due = std::min(due, wires_.now() + row_look);
    for (const Device& device : devices_) due = std::min(due, device.line.next());
    for (const InstrumentLine& instrument : instruments_) due = std::min(due, instrument.next());
    return due;
  }

  void take_all(const std::vector<LinkEvent>& events) {
    for (std::size_t i = 0; i < events.size() && !end_; ++i) {
      events_.expect(i + 1 < events.size());
      happened(events[i]);
    }
    events_.expect(false);
  }

  void happened(const LinkEvent& event) {
    if (event.link < devices_.size()) return device_says(event);
    const std::size_t i = event.link - devices_.size();
    if (i < instruments_.size() && instruments_[i].stream()) instrument_says(instruments_[i], event);
  }

  void device_says(const LinkEvent& event) {
    Device& device = devices_[event.link];
    const std::string& called = state_.course->station.devices[event.link].name;
    if (event.kind == LinkEvent::Kind::lost) {
      device.line.restart();
      return take(LinkLost{called, event.reason}, event.time);
    }
    if (event.kind == LinkEvent::Kind::up) return take(LinkUp{called}, event.time);
    const std::string_view bytes = unflooded(event);
    recorder_.raw(device.link, StoreDirection::received, event.time, bytes);
    replied(event.link, device.line.receive(bytes, event.time), event.time);
  }

  void instrument_says(InstrumentLine& instrument, const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::lost) return stream_lost(instrument, event);
    if (event.kind == LinkEvent::Kind::up) return instrument.link_is_up(event.time);
    if (instrument.receive(unflooded(event), event.time)) take(StreamStarted{instrument.slot()}, event.time);
    if (!watched_.empty()) tell_watched(instrument, event.time);
  }

  /// A unit that is switched off between two power-ups takes its link with it: whether it is back is decided when it is
  /// recorded.
  void stream_lost(const InstrumentLine& instrument, const LinkEvent& event) {
    if (state_.recording) return take(UnitFailed{instrument.slot(), event.reason}, event.time);
    perform(Note{EventKind::link,
                 say("the stream of the unit in slot {} has ended: {}", Name{instrument.slot()}, event.reason)});
  }

  void replied(std::size_t device, const std::vector<ControllerReply>& replies, double time) {
    const std::string& called = state_.course->station.devices[device].name;
    for (const ControllerReply& reply : replies)
      if (reply.problem.empty() || devices_[device].words.allows(time)) take(DeviceReply{called, reply}, time);
  }

  /// What is taken of the bytes of a link. One that floods hides what others say: it stops the rig.
  std::string_view unflooded(const LinkEvent& event) {
    return floods_.take(event, [&](const Sentence& why) { take(MustStop{why}, event.time); });
  }

  void take_orders(double now) {
    std::vector<decltype(RunEvent::what)> orders;
    if (company_.orders) conduct::show_to_company([&] { orders = company_.orders(); });
    for (auto& order : orders) take(std::move(order), now);
  }

  /// What nobody sends: time, orders, the state of the disk.
  void look_around() {
    const double now = wires_.now();
    if (const Sentence stopped = company_.looked ? company_.looked() : Sentence(); !stopped.empty())
      take(MustStop{stopped}, now);
    look_at_devices(now);
    look_at_starts(now);
    look_at_rows(now);
    if (const auto failure = recorder_.failure(); failure && !store_failed_) {
      store_failed_ = true;
      take(StoreFailed{failure->text}, now);
    }
    take_orders(now);
    if (now >= next_values_) {
      look_for_silence(now);
      tell_values(now);
      estimates_.look(
          now, state_.recording, [&](EstimateNow estimate) { take(std::move(estimate), now); },
          [&](const Note& note) { perform(note); });
    }
    if (events_.is_unjudged() || (state_.wake && now >= *state_.wake)) take(Tick{}, now);
    events_of_store_.tell();
    if (company_.show && now >= next_show_) {
      conduct::show_to_company([&] { company_.show(view(now)); });
      for (InstrumentLine& instrument : instruments_) instrument.begin_bar();
      next_show_ = now + company_.show_every;
    }
  }

  void look_at_devices(double now) {
    for (std::size_t d = 0; d < devices_.size(); ++d) {
      replied(d, devices_[d].line.at(now), now);
      if (const auto untold = devices_[d].words.take_untold(now); untold > 0)
        perform(Note{EventKind::reply, say("{}: {} more lines that nobody asked for",
                                           Name{state_.course->station.devices[d].name}, untold)});
    }
  }

  /// Rows that have come to the disk let the rig move.
  void look_at_rows(double now) {
    if (!rows_.waits()) return;
    if (rows_.look(recorder_.acknowledged().sequence, now)) take(RowsStored{rows_.stored()}, now);
    if (store_failed_ || !rows_.is_overdue()) return;
    store_failed_ = true;
    take(StoreFailed{say("the disk has not answered for {:.3g} s", company_.longest_commit)}, now);
  }

  /// Commands of instruments that were not answered are sent again.
  void look_at_starts(double now) {
    for (InstrumentLine& instrument : instruments_)
      if (const Sentence missing = instrument.at(now); !missing.empty())
        perform(Note{EventKind::stream, say("slot {}: {}", Name{instrument.slot()}, missing)});
  }

  /// A unit whose stream has ended without notice: a cable that was pulled, a link that is half open.
  void look_for_silence(double now) {
    for (InstrumentLine& instrument : instruments_) {
      const double silence = state_.recording ? instrument.silence(hearing_, now) : 0.0;
      if (silence == 0.0) continue;
      instrument.give_up();  // it is said once
      take(UnitFailed{instrument.slot(), say("no sample was received for {:.3g} s", silence)}, now);
    }
  }

  /// The executive takes a segment that has ended for complete, and the run may end before a silence is too long.
  void say_silence(const std::string& segment, double now) {
    for (const InstrumentLine& instrument : instruments_)
      if (const auto text = instrument.missing(hearing_, now); !text.empty())
        perform(Note{EventKind::stream, say("slot {}: {} of segment '{}'", Name{instrument.slot()}, text, segment)});
  }

  /// What interlocks and settle rules look at is told as soon as it has arrived.
  void tell_watched(const InstrumentLine& instrument, double time) {
    ChannelValues values;
    conduct::add_values(instrument.slot(), *instrument.stream(), &watched_, values);
    if (!values.values.empty()) take(std::move(values), time);
  }

  void tell_values(double now) {
    next_values_ = now + values_every;
    ChannelValues values;
    for (const InstrumentLine& instrument : instruments_)
      if (instrument.stream()) conduct::add_values(instrument.slot(), *instrument.stream(), nullptr, values);
    if (!values.values.empty()) take(std::move(values), now);
  }

  void take(decltype(RunEvent::what) what) { take(std::move(what), wires_.now()); }

  /// Runs one event through the executive and performs its actions. A refusal is queued and handled next.
  void take(decltype(RunEvent::what) what, double time) {
    events_.put(std::move(what), time);
    events_.drain([this](const RunEvent& event) {
      std::vector<RunAction> actions;
      state_ = step(std::move(state_), event, actions);
      if (state_.by_hand != by_hand_ && company_.by_hand) company_.by_hand(state_.by_hand);
      by_hand_ = state_.by_hand;
      for (const RunAction& action : actions) std::visit([&](const auto& one) { perform(one); }, action);
    });
  }

  /// What people see of the channels is that of one segment.
  void begin_segment(const std::string& label, double time) {
    estimates_.begin(label, time);
    for (InstrumentLine& instrument : instruments_) instrument.begin_noise();
  }

  void perform(const Ask& ask) {
    const auto& all = state_.course->station.devices;
    const auto found = std::ranges::find(all, ask.device, &StationDevice::name);
    if (found == all.end()) return;
    const auto d = static_cast<std::size_t>(found - all.begin());
    replied(d, devices_[d].line.ask(ask.request, wires_.now()), wires_.now());
  }
  void perform(const RecordSwitch& record) {
    const double now = wires_.now();
    const RunRow row = conduct::row_of(record, now);
    recorder_.journal(now, row);
    estimates_.journal(now, row);
    if (!record.on) return say_silence(record.label, now);
    hearing_.records(record.run, now);
    begin_segment(record.label, now);
    tell({EventKind::records, conduct::words_of(record, state_.course->schedule.size())});
  }
  void perform(const JournalEntry& entry) {
    const RunRow& row = entry.row;
    const double now = wires_.now();
    estimates_.journal(now, row);
    const std::uint64_t sequence = events_of_store_.record(now, row);
    if (state_.awaits_rows)
      rows_.wrote(sequence);
    else
      recorder_.flush();
  }
  void perform(const StreamSwitch& stream) {
    const auto found = std::ranges::find(instruments_, stream.slot, &InstrumentLine::slot);
    if (found == instruments_.end()) return;
    hearing_.switched();
    stream.on ? found->start(wires_.now()) : found->stop();
  }
  void perform(const Prompt& prompt) {
    events_of_store_.record({wires_.now(), EventKind::prompt, {}, prompt.text, {}});
    prompt_ = prompt;
    if (company_.ask) conduct::show_to_company([&] { company_.ask(prompt); });
  }
  void perform(const PromptClosed&) { prompt_.reset(); }
  void perform(const WakeAt&) {}  // the state has it
  void perform(const Note& note) {
    events_of_store_.record({wires_.now(), note.kind, {}, note.text, {}, note.phase});
    tell(note);
  }
  void tell(const Note& note) {
    if (company_.note) conduct::show_to_company([&] { company_.note(note, wires_.now() - begin_); });
  }
  void perform(const RunEnd& end) { end_ = end; }

  RunView view(double now) const;

  ExecutiveState state_;
  const Wires& wires_;
  Recorder& recorder_;
  const RunCompany& company_;
  conduct::Estimates estimates_;
  std::vector<Device> devices_;
  std::vector<InstrumentLine> instruments_;
  std::set<std::string> watched_;  ///< channels of interlocks and settle rules
  conduct::Hearing hearing_;
  conduct::Floods floods_;
  conduct::RowWait rows_;  ///< of the journal
  conduct::EventQueue events_;
  conduct::ToldEvents events_of_store_;
  std::map<std::string, double> by_hand_;
  std::optional<Prompt> prompt_;
  std::optional<RunEnd> end_;
  double begin_ = 0.0, next_show_ = 0.0, next_values_ = 0.0;  ///< [s]
  bool store_failed_ = false;
};

RunView Conductor::view(double now) const {
  RunView view = conduct::view_of(state_, instruments_, now - begin_, now - state_.recording_began);
  view.estimates = estimates_.view();
  view.prompt = prompt_;
  const Acknowledged on_disk = recorder_.acknowledged();
  view.acknowledged = on_disk.time - begin_;
  view.sequence = events_of_store_.told(on_disk.sequence);
  return view;
}

}  // namespace

RunEnd carry_out(ExecutiveState state, const StationParts& parts, const Wires& wires, Recorder& recorder,
                 const RunCompany& company) {
  return Conductor(std::move(state), parts, wires, recorder, company).run();
}

}  // namespace tumble
