#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tumble/core/schedule.hpp"
#include "tumble/recorder/run_row.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/tasks/stopping_rule.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/wire/controller.hpp"

namespace tumble {

/// Whether the executive may go from one state to the other: the table of docs/station.md.
bool may_follow(RunPhase from, RunPhase to);
/// complete, safe, faulted: nothing follows.
bool is_end(RunPhase phase);

struct UnitUnderTest {
  std::string slot, serial;
};

/// Everything that does not change while a plan is carried out.
struct Course {
  Station station;
  Schedule schedule;  ///< sorted by run
  std::vector<UnitUnderTest> units = {};
  bool all_units = false;                          ///< a unit that fails ends the run
  std::map<std::string, StoppingRule> until = {};  ///< by label
  double prompt_deadline = 600.0;                  ///< [s]
  double prepare_deadline = 120.0;                 ///< [s] for all devices and channels together
};

// What happens.
struct Tick {};
struct DeviceReply {
  std::string device;
  ControllerReply reply;
};
struct LinkLost {
  std::string device;
  Sentence reason;
};
struct LinkUp {
  std::string device;
};
struct ChannelValues {
  std::map<std::string, double> values = {};  ///< [SI] by channel
  std::map<std::string, std::string> words = {};
};
/// A unit under test, or its stream, has failed.
struct UnitFailed {
  std::string slot;
  Sentence reason;
};
struct EstimateNow {
  std::string slot, parameter;
  double value = 0.0, sd = 0.0;  ///< [SI]
};
/// A stream that was to be started delivers frames.
struct StreamStarted {
  std::string slot;
};
struct PromptAnswer {
  int prompt = 0;
  std::string choice, who;
};
struct RunOrder {
  enum class Kind { start, pause, pause_at_checkpoint, resume, abort, stop };  ///< stop: SIGTERM, or another terminal
  Kind kind = Kind::start;
  std::string who = {};
};
struct StoreFailed {
  Sentence reason;
};
/// So many rows of the journal, from the first of this state, are on the disk.
struct RowsStored {
  std::uint64_t rows = 0;
};
/// Ends the run by the safe list for a reason that the shell sees and that no other event has: a device that floods its
/// link.
struct MustStop {
  Sentence reason;
};
struct RunEvent {
  double time = 0.0;  ///< [s] of the station's clock
  std::variant<Tick, DeviceReply, LinkLost, LinkUp, ChannelValues, UnitFailed, StreamStarted, EstimateNow, PromptAnswer,
               RunOrder, StoreFailed, RowsStored, MustStop>
      what = Tick{};
  bool more = false;  ///< others have arrived already: whether a device is silent is judged after them
};

// What is to be done, in the order of the list.
struct Ask {
  std::string device;
  ControllerRequest request;
  double deadline = 0.0;  ///< [s]
  bool urgent = false;    ///< the request that is outstanding at this device is given up
};
struct RecordSwitch {
  bool on = false;
  std::size_t segment = 0;
  std::string label;
  int run = 1, attempt = 1;
};
/// A row of the journal. What moves the rig is sent when the rows before it are on the disk: the shell waits for the
/// disk with each row, or says RowsStored and goes on looking at the rig (`awaits_rows`).
struct JournalEntry {
  RunRow row;
};
/// The commands of a unit's declaration that start its stream, or stop it.
struct StreamSwitch {
  std::string slot;
  bool on = false;
};
struct Prompt {
  int id = 0;
  Sentence text;
  std::vector<std::string> choices;
  std::string standard;              ///< the choice that is offered
  double deadline = 0.0;             ///< [s]
  std::string at_deadline = "hold";  ///< what happens then: axes come to rest, and the question stays open
  std::string failed_segment = {};   ///< label of the segment that has failed; empty: the question is part of the plan
};
struct PromptClosed {
  int id = 0;
};
struct WakeAt {
  double time = 0.0;  ///< [s] a Tick is wanted; replaces the one before
};
struct Note {
  EventKind kind = EventKind::notice;
  Sentence text;
  std::optional<RunPhase> phase = {};  ///< that is entered
};
struct RunEnd {
  RunEnding ending = RunEnding::complete;
  Sentence text;  ///< for a person
};
using RunAction =
    std::variant<Ask, RecordSwitch, JournalEntry, StreamSwitch, Prompt, PromptClosed, WakeAt, Note, RunEnd>;

/// A request on its way to a device.
struct PendingRequest {
  enum class Purpose { poll, verify, prepare, motion, power, rest, finish, safe };
  ControllerRequest request;
  Purpose purpose = Purpose::poll;
  int sent = 0;          ///< how often
  std::size_t safe = 0;  ///< of the safe list: its index
};

/// A set point that was acknowledged, and is to be read back.
struct OpenSetPoint {
  int axis = 1;
  double value = 0.0;  ///< [SI] of the controller
  double due = 0.0;    ///< [s] until when it must be read back
};

/// How far the executive is with a device.
struct DeviceProgress {
  std::deque<PendingRequest> waiting;
  std::optional<PendingRequest> asked;
  double due = 0.0;    ///< [s] deadline of what was asked
  double heard = 0.0;  ///< [s] last good reply
  double next_poll = 0.0;
  std::size_t turn = 0;  ///< of the polls
  std::vector<OpenSetPoint> set_points = {};
  int refusals = 0;      ///< of polls, one after the other
  bool lost = false;     ///< nothing was heard for too long, or it is cut
  bool cut = false;      ///< nothing can be sent
  double lost_at = 0.0;  ///< [s]
};

/// A line through readings, from the first that lay within tolerance.
struct SettleWindow {
  double begin = 0.0, n = 0.0, t = 0.0, x = 0.0, tt = 0.0, tx = 0.0;
};

/// Whether an axis that turns does so as commanded. The rates on its way lie between the rate before the command and
/// the commanded one.
struct RateWatch {
  double low = 0.0, high = 0.0;             ///< [rad/s] that it had until its command was answered
  std::optional<double> fastest = {};       ///< [rad/s] of a motion whose rate is not demanded; absent: not known
  std::optional<double> too_fast = {};      ///< [s] since when it is faster than the station allows
  std::optional<double> strange = {};       ///< [s] since when nothing explains its rate
  double nearest = -1.0, nearest_at = 0.0;  ///< [rad/s] least departure from what was demanded, [s]; negative: none yet
  int readings = 0;                         ///< faster than the station allows, one after the other
  enum class Verdict { good, too_fast, strange, astray } verdict = Verdict::good;
};

/// Demand on an axis, and its readings.
struct AxisProgress {
  /// rest: it was stopped; moving: a ramp or slew goes on
  enum class Demand { none, rest, position, rate, sine, temperature, moving };
  Demand demand = Demand::none;
  double value = 0.0;                                 ///< [SI] of the rig
  double period = 0.0;                                ///< [s] of a sine
  bool turned = true;                                 ///< at a rate, since the last position
  double turns = 0.0;                                 ///< [rad] whole turns that the plan does not count
  std::optional<double> position, rate, temperature;  ///< last read
  double read_at = -1.0;                              ///< [s]
  std::deque<std::pair<double, double>> turned_at;  ///< [s], [rad]: the last positions, of a device that reads no rate
  SettleWindow window = {};
  bool settled = false;
  bool arrived = false;             ///< it has settled since it was commanded
  std::optional<double> goal = {};  ///< [rad] the last angle commanded to the controller, with its turns
  RateWatch watch = {};
  int outside = 0;                ///< readings out of tolerance, one after the other
  int at_rest = 0;                ///< readings with a rate of zero, one after the other
  int beyond = 0;                 ///< readings beyond its travel and on the way outwards, one after the other
  double sum = 0.0, count = 0.0;  ///< of what is demanded, while recording
  bool ramping = false;
  double ramp_from = 0.0, ramp_to = 0.0, ramp_rate = 0.0, ramp_begin = 0.0, next_set = 0.0;
};

/// How far the stream of an instrument is, where commands start it.
struct StreamProgress {
  enum class Status { off, starting, on } status = Status::off;
  double due = 0.0;  ///< [s] until when it must have started
};

struct SegmentProgress {
  enum class Status { open, complete, skipped };
  Status status = Status::open;
  int attempts = 0;
};

struct OpenPrompt {
  Prompt prompt;
  enum class About { failure, by_hand, power } about = About::failure;
  bool overdue = false;
};

struct SafeProgress {
  bool due = false;  ///< those that it waits for are confirmed or overdue
  bool sent = false, replied = false, confirmed = false, overdue = false;
  double since = 0.0;           ///< [s] when it became due
  double sent_at = 0.0;         ///< [s]
  std::optional<double> again;  ///< [s] when it may be sent again, after the device was read
};

struct KnownChannel {
  ChannelReading value;
  double time = 0.0;
};

struct InterlockProgress {
  bool met = true;
  std::optional<double> changing_since;  ///< [s] since when what is observed differs from `met`
};

/// All that the executive knows. A value: it may be copied, stored and compared in tests.
struct ExecutiveState {
  std::shared_ptr<const Course> course;
  RunPhase phase = RunPhase::idle;
  double now = 0.0;
  double entered = 0.0;  ///< [s] when the phase was entered
  std::size_t segment = 0;
  std::vector<SegmentProgress> segments;
  std::vector<DeviceProgress> devices;
  std::vector<AxisProgress> axes;
  std::vector<StreamProgress> streams;  ///< by instrument
  std::map<std::string, KnownChannel> channels;
  std::vector<InterlockProgress> interlocks;
  std::vector<SafeProgress> safe;
  std::map<std::string, double> by_hand;     ///< where a person has put these axes
  std::vector<std::string> units_out;        ///< slots
  std::map<std::string, Sentence> failures;  ///< of commands that are outstanding: what went wrong, by device
  std::optional<OpenPrompt> prompt;
  int prompts = 0;
  int failed_attempts = 0;  ///< of this segment, one after the other
  bool recording = false;
  bool attempt_open = false;  ///< its begin is in the journal, its end is not
  double recording_began = 0.0;
  std::map<std::string, bool> good_enough;  ///< by slot, of the stopping rule
  std::optional<double> rule_reached;
  bool pause_wanted = false;
  bool motions_sent = false;  ///< of this attempt
  double settle_by = 0.0;     ///< [s]
  int restarts = 0;           ///< of the dwell time, in this attempt
  RunPhase after_hold = RunPhase::between;
  int powered_run = 0;  ///< power-up that the unit is in; 0: not known
  enum class Power { idle, off, wait, on, warm } power = Power::idle;
  double power_until = 0.0;
  bool resumed = false;
  bool awaits_rows = false;                 ///< the shell says when rows are on the disk
  std::uint64_t rows = 0, rows_stored = 0;  ///< of the journal: written, and on the disk
  std::optional<double> held_since;         ///< [s] since when a motion waits for its row
  double decided = 0.0;                     ///< [s] when stopping was decided
  RunEnding ending = RunEnding::complete;
  Sentence reason;
  std::optional<double> wake;
};

/// The state before anything has happened.
ExecutiveState start_state(std::shared_ptr<const Course> course);

/// The state from which an interrupted run is carried on: segments that count are not repeated, the unfinished one is
/// attempt n+1. Where the schedule has several power-ups, the power-up that was interrupted is repeated as a whole,
/// because nobody knows whether the unit stayed on.
ExecutiveState resume_state(std::shared_ptr<const Course> course, const std::vector<RunRow>& journal);

/// Steps the state of a run by one event: a pure function. It reads no clock and has no memory except the state.
///
/// Given     state    from start_state(), resume_state() or the step before
///           event    with its time; a time before that of the last event counts as that
///
/// Returned  the new state; `actions` are appended in the order in which they are to be done
ExecutiveState step(ExecutiveState state, const RunEvent& event, std::vector<RunAction>& actions);

}  // namespace tumble
