#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <ctime>
#include <memory>

#include "live_block.hpp"
#include "live_output.hpp"
#include "tumble/language/said.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/station/recorder_session.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

struct RecordArguments {
  std::string instrument, link, output, duration, silence = "10 s";
  bool no_start = false, keep = false;
};

volatile std::sig_atomic_t wanted_end = 0;
std::atomic<std::time_t> wanted_at = 0;

/// Once: the recording ends. Again, seconds later: at once, and its store remains. A terminal and a program in between
/// may both send a signal: two at once are one.
extern "C" void end_recording(int number) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (wanted_end == 0) wanted_at = now.tv_sec;
  wanted_end = 1;
  if (now.tv_sec - wanted_at <= 1) return;
  std::signal(number, SIG_DFL);
  std::raise(number);
}

std::string utc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string clock_text(double seconds) {
  const auto tenths = static_cast<long long>(std::floor(seconds * 10.0));
  return fmt::format("{:02}:{:02}:{:02}.{}", tenths / 36000, tenths / 600 % 60, tenths / 10 % 60, tenths % 10);
}

std::string number_text(double value) { return std::isnan(value) ? "" : fmt::format("{:.6g}", value); }

/// Each channel with its mean, standard deviation and Allan deviation at 1 s.
std::string noise_table(const InstrumentRecorder& instrument, const Terminal& terminal) {
  using Align = TextColumn::Align;
  TextColumn names{"channel", "", {}, Align::left}, units{"unit", "", {}, Align::left};
  TextColumn samples{"samples", "", {}}, means{"mean", "", {}}, deviations{"sd", "", {}}, allans{"Allan 1 s", "", {}};
  for (const auto& shown : instrument.shown()) {
    const FrameChannel& channel = shown.channel;
    const LiveNoise& noise = shown.noise;
    if (noise.count() == 0) continue;
    const double a_second = channel.increment ? instrument.rate() : 1.0;
    names.cells.push_back(channel.name);
    units.cells.push_back(channel.unit.text());
    samples.cells.push_back(fmt::format("{}", noise.count()));
    means.cells.push_back(number_text(channel.unit.from_si(noise.mean() * a_second)));
    deviations.cells.push_back(fmt::format("{:.3g}", channel.unit.difference_from_si(noise.sd() * a_second)));
    allans.cells.push_back(std::isnan(noise.allan())
                               ? ""
                               : fmt::format("{:.3g}", channel.unit.difference_from_si(noise.allan() * a_second)));
  }
  if (names.cells.empty()) return "";
  return table_said(terminal, {names, units, samples, means, deviations, allans});
}

Sentence counts_said(const InstrumentRecorder& instrument) {
  const FrameCounts& counts = instrument.counts();
  return say("{} frames, {:.5g} a second; {} lost, {} damaged, {} repeated", counts.channel_frames, instrument.rate(),
             counts.lost, counts.damaged.count, counts.repeated.count);
}

/// What is shown while it records: one block on a terminal, else a line every ten seconds.
class Display {
 public:
  explicit Display(const Terminal& terminal) : terminal_(terminal), block_(terminal) {}

  void show(const RecordView& view) {
    last_ = noise_table(*view.instrument, terminal_);
    counts_ = counts_said(*view.instrument);
    const double every = terminal_.live ? 0.5 : 10.0;
    if (view.elapsed < next_) return;
    next_ = view.elapsed + every;
    const Sentence head =
        say("{}, on disk up to {}: {}", Name{clock_text(view.elapsed)}, Name{clock_text(view.on_disk)}, counts_);
    if (terminal_.live)
      block_.show(in_language(terminal_.language, head) + "\n\n" + last_ + "\n" +
                  in_language(terminal_.language, Sentence("Ctrl+C ends the recording")) + "\n");
    else
      note(terminal_, Sentence(head));
  }
  void end() { block_.clear(); }
  std::string result() const { return last_.empty() ? "" : in_language(terminal_.language, counts_) + "\n\n" + last_; }

 private:
  const Terminal& terminal_;
  LiveBlock block_;
  std::string last_;
  Sentence counts_;
  double next_ = 1.0;
};

/// 0 where the option was not given.
double seconds_of(const std::string& option, const std::string& text) {
  if (text.empty()) return 0.0;
  const Sentence expected = say("{} {}: a duration above 0 expected, for example '10 min'", Name{option}, Name{text});
  try {
    const double seconds = parse_si(text, Unit::parse("s"));
    if (seconds > 0.0 && std::isfinite(seconds)) return seconds;
  } catch (const Error& error) {
    throw Error(Error::Kind::bad_input, say("{} ({})", expected, reason_of(error)));
  }
  throw Error(Error::Kind::bad_input, expected);
}

/// All that is wrong at once.
RecordRequest request_of(const RecordArguments& arguments) {
  Problems problems;
  const auto collected = [&](const auto& work) {
    try {
      work();
    } catch (const Error& error) {
      problems.insert(problems.end(), error.problems.begin(), error.problems.end());
    }
  };
  RecordRequest request;
  request.instrument = arguments.instrument;
  request.output = arguments.output;
  request.start = !arguments.no_start;
  request.keep = arguments.keep;
  collected([&] { request.link = parse_link(arguments.link); });
  collected([&] { check_output("-o", arguments.output, {}, {".h5", ".hdf5"}); });
  collected([&] { request.duration = seconds_of("--for", arguments.duration); });
  collected([&] { request.silence = seconds_of("--silence", arguments.silence); });
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return request;
}

int run(const RecordArguments& arguments, const Terminal& terminal) {
  constexpr int bad_data = 3;
  const RecordRequest request = request_of(arguments);
  begin_live_output(terminal);
  Display display(terminal);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, end_recording);
  std::signal(SIGPIPE, SIG_IGN);  // the recording goes on when a pipe of its messages ends
  RecordWorld world{wall_time, [] { return utc(); }, [] { return wanted_end != 0; }};
  world.show = [&](const RecordView& view) { display.show(view); };
  world.sealing = [&] { display.end(); };
  const RecordOutcome outcome = tumble::record(request, world);
  print(display.result() + "\n" + to_text(outcome.sealed.findings, terminal.width, terminal.language));
  note(terminal, say("wrote {}", Name{outcome.sealed.path}));
  if (!outcome.store.empty()) note(terminal, say("the live store is kept in {}", Name{outcome.store}));
  if (!outcome.whole) complain(terminal, outcome.ending);
  flush_live_output();
  return outcome.whole ? 0 : bad_data;
}

}  // namespace

Verb record_verb() {
  auto arguments = std::make_shared<RecordArguments>();
  return {"record",
          "Record the stream of an instrument, with its noise as it comes",
          {{"INSTRUMENT", &arguments->instrument,
            "declaration of its frames: a name of `tumble list instruments`, or a file (.toml);\nvariants follow a "
            "colon: kvh_1775:gyro_rate",
            true},
           {"--link", &arguments->link,
            "tcp:HOST:PORT, udp:HOST:PORT, udp:PORT to listen,\nor serial:DEVICE[:BAUD[:8N1]]", true, "LINK"},
           {"-o,--output", &arguments->output, "recording to write (.h5); until it ends, a store lies beside it", true},
           {"--for", &arguments->duration, "how long (default: until Ctrl+C)", false, "DURATION"},
           {"--silence", &arguments->silence, "without a byte for so long, the link counts as lost", false, "DURATION"},
           {"--no-start", &arguments->no_start, "do not send the commands that start the stream: it runs already"},
           {"--keep", &arguments->keep, "keep the store with the raw bytes when the recording is written"}},
          "Examples:\n"
          "  tumble record kvh_1775 --link serial:/dev/ttyUSB0:921600 -o fog.h5 --for \"10 min\"\n"
          "  tumble record my_gyro.toml --link tcp:192.168.0.10:4001 -o gyro.h5\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
