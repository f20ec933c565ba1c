#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/tasks/cut.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct ConvertArguments {
  std::string recording, output, from, to;
  std::vector<std::string> sets, topics, channels;
};

/// "10", "10 s" and "2 min" [s].
double time_of(const std::string& text, const std::string& option, double otherwise) {
  if (text.empty()) return otherwise;
  try {
    const Quantity time = parse_quantity(text);
    return time.bare ? time.value : parse_si(text, Unit::parse("s"));
  } catch (const Error&) {
    throw Error(Error::Kind::bad_input,
                say("{} {}: a time is expected, as in 10, \"10 s\" or \"2 min\"", option, text));
  }
}

int run(const ConvertArguments& arguments, const Terminal& terminal) {
  check_recording_output(arguments.output, {arguments.recording});
  auto options = tumble::read_options(parse_sets(arguments.sets, arguments.topics));
  options.only = arguments.channels;
  const TimeSpan all, span{time_of(arguments.from, "--from", all.from), time_of(arguments.to, "--to", all.to)};
  {
    ProgressLine line(terminal);
    const auto path = readable(arguments.recording);
    tumble::require_channels(path, options);
    if (arguments.from.empty() && arguments.to.empty())
      tumble::convert(path, arguments.output, options, line.progress());
    else
      tumble::cut(path, arguments.output, options, span, line.progress());
  }
  if (arguments.output != standard_output) note(terminal, say("wrote {}", Name{arguments.output}));
  return 0;
}

}  // namespace

Verb convert_verb() {
  auto arguments = std::make_shared<ConvertArguments>();
  return {
      "convert",
      "Write a recording in another format",
      {{"RECORDING", &arguments->recording, "recording to read; - reads standard input", true},
       {"-o,--output", &arguments->output,
        "recording to write; the end of its name selects the format; - writes CSV to standard\noutput", true},
       {.name = "--from", .value = &arguments->from, .description = "write samples from this time on", .type = "TIME"},
       {.name = "--to", .value = &arguments->to, .description = "write samples up to this time", .type = "TIME"},
       {.name = "--channel",
        .value = &arguments->channels,
        .description = "channel to write; repeatable (default: all)",
        .type = "NAME"},
       topic_argument(arguments->topics),
       reading_sets(arguments->sets)},
      "Examples:\n"
      "  tumble convert data.csv -o data.h5\n"
      "  tumble convert long.h5 -o part.csv --from 10 --to \"2 min\" --channel gyro.x\n"
      "  tumble convert old.csv -o new.csv --set rate=100 --set unit.x=deg/h --set missing=NA\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
