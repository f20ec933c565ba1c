#pragma once

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "tumble/station/executive.hpp"

namespace tumble::testing {

/// Fault of a device of the bench, from `from` until `until`.
struct BenchFault {
  enum class Kind {
    silent,      ///< requests and replies are lost, without notice
    cut,         ///< the same, and the executive gets the loss of the link at `from`, and its return at `until`
    deaf_reply,  ///< requests are carried out, replies of `verb` are lost
    refuses,     ///< `verb` is refused
    stuck,       ///< the axis goes on as it moves, and `stop` changes nothing
    off_rate,    ///< the rate differs by `size` [1] from the demand
    noise,       ///< position and rate readings alternate by +- `size` [rad, rad/s]
    slow,        ///< the chamber changes with `size` [K/s]
    ignores,     ///< commands are acknowledged, and nothing is done
    alarm,       ///< the state is `alarm`
    wrong_reply  ///< replies are those of another verb
  };
  Kind kind = Kind::silent;
  std::string device;
  double from = 0.0, until = std::numeric_limits<double>::infinity();
  std::optional<ControllerVerb> verb = {};
  double size = 0.0;
};

/// Ideal axes behind ideal protocols, in simulated time, with faults: drives step() as a shell would.
class ExecutiveBench {
 public:
  explicit ExecutiveBench(std::shared_ptr<const Course> course, std::optional<ExecutiveState> state = {});

  void fault(BenchFault fault);
  void at(double time, decltype(RunEvent::what) what);
  /// How a prompt is answered, and after how long [s]; absent: never.
  using Answering = std::function<std::optional<std::pair<double, std::string>>(const Prompt&)>;
  Answering answering;
  /// Runs until the end, or until that time. Returned: how it ended.
  std::optional<RunEnding> run(double until);
  /// Nothing is looked at until that time [s]; then all that has arrived comes in one list.
  void sleep(double until);

  ExecutiveState state;
  struct Asked {
    double time = 0.0;
    Ask ask;
    RunPhase phase = RunPhase::idle;  ///< after the step
  };
  std::vector<Asked> asked;
  std::vector<RunRow> rows;
  std::vector<Prompt> prompts;
  std::vector<Note> notes;
  struct Recorded {
    double begin = 0.0, end = 0.0;
    RecordSwitch what;
  };
  std::vector<Recorded> recorded;
  std::optional<RunEnd> ended;
  double ended_at = 0.0;
  std::vector<std::string> faults_of_order;  ///< transitions that the table lacks, motions after the safe list began
  double reply_after = 0.002;                ///< [s]
  std::map<std::string, double> phase_began = {};  ///< the first time of each phase, by name
  double true_rate(const std::string& axis) const;
  double true_position(const std::string& axis) const;
  std::size_t steps = 0;
  bool reads_rate = true;   ///< the controllers of turning axes read their rate
  double resolution = 0.0;  ///< [rad] of the positions that they read

 private:
  struct Scheduled {
    double time = 0.0;
    std::size_t order = 0;
    decltype(RunEvent::what) what;
    bool operator>(const Scheduled& other) const {
      return time != other.time ? time > other.time : order > other.order;
    }
  };
  struct Physical {
    enum class Mode { rest, position, rate, sine } mode = Mode::rest;
    double position = 0.0, rate = 0.0, target = 0.0, speed = 1.0;
    double temperature = 293.15, set_point = 293.15;
  };

  const BenchFault* fault_of(BenchFault::Kind kind, const std::string& device, double time) const;
  void take(const RunEvent& event);
  void perform(const std::vector<RunAction>& actions, RunPhase before);
  void carry_out(const Ask& ask);
  void command(Physical& axis, const StationAxis& setup, const ControllerRequest& request);
  ControllerReply reply_to(const Ask& ask);
  void move(double to);

  std::shared_ptr<const Course> course_;
  std::vector<BenchFault> faults_;
  std::priority_queue<Scheduled, std::vector<Scheduled>, std::greater<>> events_;
  std::size_t order_ = 0;
  std::optional<double> wake_;
  std::vector<Physical> axes_;
  double now_ = 0.0;
  bool safe_began_ = false;
  long readings_ = 0;
};

/// A table with one axis and a chamber, a supply where `supply` is set; settling takes about 1 s at the table.
Station bench_station(bool supply = false);
Segment bench_segment(const std::string& label, double duration, std::map<std::string, Motion> axes, int run = 1);
std::shared_ptr<const Course> bench_course(Schedule schedule, Station station = bench_station());
/// Rest, two rates, rest at 90 deg; 10 s each.
Schedule table_schedule();
Motion hold_at(double degrees);             ///< [deg]
Motion turn_at(double degrees_per_second);  ///< [deg/s]
Motion warm_to(double celsius);             ///< [degC]

/// The rows of one kind in the journal of the bench.
std::vector<RunRow> rows_of_kind(const ExecutiveBench& bench, RunRow::Kind kind);
/// Requests that the bench got with this verb.
std::vector<ExecutiveBench::Asked> asked_for(const ExecutiveBench& bench, ControllerVerb verb);

}  // namespace tumble::testing
