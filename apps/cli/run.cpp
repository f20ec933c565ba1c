#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>

#include "archive_options.hpp"
#include "live_output.hpp"
#include "run_display.hpp"
#include "tumble/desk/archived_run.hpp"
#include "tumble/desk/run_plan.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/rehearsal/served_rig.hpp"
#include "tumble/station/guard.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/station/typed_order.hpp"
#include "tumble/tasks/stopping_rule.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"
#include "typed_lines.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

using What = decltype(RunEvent::what);

struct RunArguments {
  std::string plan, station, output, who, accept_expired, speed = "1";
  std::vector<std::string> units;
  ArchiveOptions archive;
  bool dry_run = false, virtual_rig = false;
};

volatile std::sig_atomic_t run_should_end = 0;

/// The run ends by the safe list, once; further signals change nothing, because nothing ends it sooner.
extern "C" void end_run(int) { run_should_end = 1; }

/// The rig is not left in motion while a dead process writes its memory to a file, which may take minutes.
extern "C" void end_by_fault(int number) {
  leave_rig_to_guard();
  unlink_unfinished();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &parts);
  return text;
}

/// SLOT=SERIAL
std::map<std::string, std::string> units_of(const std::vector<std::string>& texts) {
  std::map<std::string, std::string> units;
  for (const auto& text : texts) {
    const auto unit = key_and_value(text);
    if (!unit || unit->first.empty() || unit->second.empty())
      throw Error(Error::Kind::bad_input, say("--unit {}: write SLOT=SERIAL, for example --unit a=0173", Name{text}));
    if (!units.insert(*unit).second)
      throw Error(Error::Kind::bad_input, say("--unit: slot '{}' has two units", unit->first));
  }
  return units;
}

/// What a person at this terminal orders.
class Operator {
 public:
  /// `ask_again`: a line was no answer to the open question.
  Operator(std::string who, std::function<void(const Prompt&)> ask_again)
      : who_(std::move(who)), ask_again_(std::move(ask_again)) {}

  void asked(const Prompt& prompt) { prompt_ = prompt; }
  std::vector<What> orders() {
    std::vector<What> orders;
    if (run_should_end && !ended_) {
      ended_ = true;
      orders.push_back(RunOrder{RunOrder::Kind::stop, who_});
    }
    if (const auto line = next_typed_line()) answer(*line, orders);
    return orders;
  }

 private:
  void answer(const std::string& line, std::vector<What>& orders) {
    const auto order = order_of_line(line, prompt_, who_);
    if (order && std::holds_alternative<PromptAnswer>(*order)) prompt_.reset();
    if (order)
      orders.push_back(*order);
    else if (prompt_)
      ask_again_(*prompt_);
  }

  std::string who_;
  std::function<void(const Prompt&)> ask_again_;
  std::optional<Prompt> prompt_;
  bool ended_ = false;
};

/// Whether all links lead to this computer, so that a virtual rig may be at them.
bool is_here(const Station& station) {
  const auto is_local = [](const std::string& link) {
    return link.empty() || link.starts_with("tcp:127.0.0.1:") || link.starts_with("tcp:localhost:") ||
           link.starts_with("serial:/dev/pts/");
  };
  return std::ranges::all_of(station.devices, is_local, &StationDevice::link) &&
         std::ranges::all_of(station.instruments, is_local, &StationInstrument::link);
}

/// A real rig has the clock of the wall.
double allowed_speed(const std::string& text, const Station& station) {
  const double speed = speed_of(text);
  if (speed == 1.0 || is_here(station)) return speed;
  throw Error(Error::Kind::bad_input,
              say("--speed {}: the station has devices that are not on this computer, so its rig is no virtual one",
                  Name{text}));
}

void print_timeline(const Plan& plan, const Terminal& terminal) {
  const auto rules = stopping_rules(plan);
  double time = 0.0;
  for (const Segment& segment : plan.schedule) {
    const auto rule = rules.find(segment.label);
    const Sentence until =
        rule == rules.end() ? Sentence()
                            : say(" at most; until {}, from {:g} s on", Name{rule->second.text}, rule->second.at_least);
    print_said(terminal, say("{}  {} ({:g} s{})\n", Name{fmt::format("{:>9}", hours_text(time))}, Name{segment.label},
                             segment.duration, until));
    time += segment.duration;
  }
  print_said(terminal,
             say("{}  end, without ways, settling and prompts\n", Name{fmt::format("{:>9}", hours_text(time))}));
}

/// A rule about a parameter that the method's own prediction of the plan lacks would never end its segment.
void note_doubtful_rules(const Plan& plan, const Terminal& terminal) {
  std::map<std::string, std::string> parameter_of;  // by the text of the rule
  for (const auto& [label, rule] : stopping_rules(plan)) parameter_of[rule.text] = rule.parameter;
  if (parameter_of.empty() || plan.method.empty() || !find_method(plan.method).predict) return;
  std::vector<std::string> names;
  try {
    for (const Parameter& parameter : predict(plan).parameters) names.push_back(parameter.name);
  } catch (const Error&) {
    return;  // a plan that cannot be predicted
  }
  for (const auto& [text, parameter] : parameter_of)
    if (std::ranges::find(names, parameter) == names.end())
      note(terminal, say("'{}': the prediction of this plan has no such parameter{}; without it, a segment lasts "
                         "its whole duration",
                         text, did_you_mean(parameter, names)));
}

/// The operator, where --by names nobody else.
ArchiveOptions archived_by(ArchiveOptions archive, const std::string& who) {
  if (archive.who.empty()) archive.who = who;
  return archive;
}

/// A rig in motion is never left alone: the process goes on when a pipe or a terminal of it ends, it is not suspended
/// by Ctrl+Z, and it does not stop in the background where it reads or writes the terminal. Every signal that would end
/// it, and is no fault of the program, ends the run by the safe list; what cannot be caught is seen by its guard.
void stay_with_the_rig() {
  for (const int number :
       {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGXCPU, SIGPWR, SIGIO})
    std::signal(number, end_run);
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) std::signal(number, end_run);
  for (const int number : {SIGPIPE, SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(number, SIG_IGN);
  struct sigaction fault {};
  fault.sa_handler = end_by_fault;
  fault.sa_flags = SA_ONSTACK;
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS, SIGTRAP})
    sigaction(number, &fault, nullptr);
}

/// The rig of the plan, where it is to be played here: a real one at these links would have to be elsewhere.
std::unique_ptr<ServedRig> rig_played_here(PlannedRunAtStation& run) {
  if (run.rig.empty()) return nullptr;
  if (!is_here(run.station))
    throw Error(Error::Kind::bad_input,
                "--virtual-rig: the station has devices that are not on this computer: a run would move them");
  run.seed = ServedRig::seed;
  return std::make_unique<ServedRig>(run.plan, run.station, run.speed);
}

int carry_on(PlannedRunAtStation& run, const ArchiveOptions& to_archive, const Terminal& terminal) {
  note_doubtful_rules(run.plan, terminal);
  run.show_estimates = true;  // others may watch it
  auto archive = optional_archive(to_archive);
  stay_with_the_rig();
  begin_live_output(terminal);
  begin_typed_lines();
  RunDisplay display(terminal);
  auto rig = rig_played_here(run);
  RunDesk desk;
  run.desk = &desk;
  Operator person(run.who, [&](const Prompt& prompt) { display.ask(prompt); });
  run.clock = wall_time;
  run.started = utc_now();
  run.company.orders = [&] { return person.orders(); };
  run.company.ask = [&](const Prompt& prompt) {
    person.asked(prompt);  // first: an answer counts where nobody can read the question
    display.ask(prompt);
  };
  run.company.note = [&](const Note& note, double time) { display.tell(note, time); };
  run.company.show = [&](const RunView& view) { display.show(view); };
  const RunEnd end = run_plan(run);
  rig.reset();  // who is told of the end may begin the next run at the same links
  desk.ended(end);
  display.end();
  try {
    print_said(terminal, say("\n{}\n", said_ending(end.ending, end.text)));
  } catch (const Error&) {  // nobody reads it; the run is kept and sealed all the same
  }
  if (end.ending != RunEnding::complete) {
    note(terminal, say("the run is kept in {}; it goes on with: tumble resume {} --operator NAME", Name{run.folder},
                       Name{run.folder}));
    return 3;
  }
  Disk disk;
  for (const auto& sealed : seal(run.folder, disk)) note(terminal, say("wrote {}", Name{sealed.path}));
  if (archive) note_deposited(terminal, put_in(*archive, deposit_of_run(run.folder), act_of(to_archive)));
  return 0;
}

int run(const RunArguments& arguments, const Terminal& terminal) {
  PlannedRunAtStation run;
  run.plan = tumble::load_plan(arguments.plan, {});
  run.station = load_station(arguments.station);
  run.units = units_of(arguments.units);
  run.who = arguments.who;
  run.date = today();
  run.speed = allowed_speed(arguments.speed, run.station);
  run.rig = arguments.virtual_rig ? "virtual" : "";
  run.accept_expired = arguments.accept_expired;
  run.folder =
      arguments.output.empty() ? std::filesystem::path(arguments.plan).stem().string() + "-run" : arguments.output;
  if (!arguments.dry_run) return carry_on(run, archived_by(arguments.archive, run.who), terminal);
  Station station = run.station;
  parts_of(station);
  StationRequest request;
  request.units = run.units;
  request.date = run.date;
  request.accept_expired = run.accept_expired;
  if (auto problems = check_station(run.plan, station, request); !problems.empty())
    throw Error(Error::Kind::bad_input, std::move(problems));
  print_timeline(run.plan, terminal);
  note_doubtful_rules(run.plan, terminal);
  return 0;
}

struct ResumeArguments {
  std::string run, who, station, accept_expired, speed = "1";
  ArchiveOptions archive;
};

int resume(const ResumeArguments& arguments, const Terminal& terminal) {
  if (process_at_desk(arguments.run))
    throw Error(Error::Kind::bad_input, say("the run '{}' goes on; where it is paused: tumble answer {} resume "
                                            "--operator NAME",
                                            arguments.run, Name{arguments.run}));
  const std::filesystem::path folder(arguments.run);
  PlannedRunAtStation run;
  run.resume = true;
  run.folder = arguments.run;
  run.plan = tumble::load_plan((folder / "plan.toml").string(), {});
  const StoreContent content = visit_store(arguments.run, [](const StoreItem&) {});
  const auto& facts = content.facts;
  run.units = content.units;
  const bool named = !arguments.station.empty();
  if (!named && !facts.contains("station_file"))
    throw Error(Error::Kind::bad_input,
                say("'{}' does not say which station it used: name it, --station", arguments.run));
  run.station = load_station(named ? arguments.station : file_named_in({}, facts.at("station_file")));
  check_carried_on(facts, run.plan, run.station, named);
  run.who = arguments.who;
  run.date = today();
  run.speed = allowed_speed(arguments.speed, run.station);
  run.accept_expired = arguments.accept_expired;
  if (facts.contains("rig")) run.rig = facts.at("rig");
  return carry_on(run, archived_by(arguments.archive, run.who), terminal);
}

}  // namespace

Verb run_verb() {
  auto arguments = std::make_shared<RunArguments>();
  return {
      "run",
      "Carry out a plan at a station, and record it",
      {{"PLAN", &arguments->plan, "plan file (.toml) with [rig] and [[schedule]]", true},
       {"--station", &arguments->station, "station file (.toml): which controller on which link is which axis", true},
       {"--unit", &arguments->units, "which unit is in which slot: SLOT=SERIAL; repeatable", true},
       {"--operator", &arguments->who, "who carries it out", true},
       {"-o,--output", &arguments->output, "folder of the run (default: <plan>-run in this folder)"},
       {"--speed", &arguments->speed, "how fast the clock of the rig goes: other than 1 only against a virtual rig"},
       {"--virtual-rig", &arguments->virtual_rig,
        "play the rig too, at the links of the station, which must be on this computer"},
       archive_argument(arguments->archive),
       {"--dry-run", &arguments->dry_run, "check everything and print the timeline; nothing is moved"},
       {"--accept-expired", &arguments->accept_expired,
        "reason why equipment out of calibration may be used; it is recorded"}},
      "Examples:\n"
      "  tumble run north.toml --station bench.toml --unit a=0173 --operator \"Li Wei\" --dry-run\n"
      "  tumble run north.toml --station bench.toml --unit a=0173 --operator \"Li Wei\" -o run-0173\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

Verb resume_verb() {
  auto arguments = std::make_shared<ResumeArguments>();
  return {"resume",
          "Carry on a run that was interrupted: the unfinished segment is repeated",
          {{"RUN", &arguments->run, "folder of the run", true},
           {"--operator", &arguments->who, "who carries it out", true},
           {"--station", &arguments->station, "station file (default: that of the run, where it was)"},
           {"--accept-expired", &arguments->accept_expired,
            "reason why equipment out of calibration may be used; it is recorded"},
           archive_argument(arguments->archive),
           {"--speed", &arguments->speed, "as of tumble run"}},
          "Example:\n"
          "  tumble resume run-0173 --operator \"Li Wei\"\n",
          [arguments](const Terminal& terminal) { return resume(*arguments, terminal); }};
}

}  // namespace tumble::cli
