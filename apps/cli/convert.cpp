#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct Arguments {
  std::string recording, output;
  std::vector<std::string> sets, topics;
};

int run(const Arguments& arguments, const Terminal& terminal) {
  check_recording_output(arguments.output, {arguments.recording});
  const auto options = tumble::read_options(parse_sets(arguments.sets, arguments.topics));
  {
    ProgressLine line(terminal);
    tumble::convert(readable(arguments.recording), arguments.output, options, line.progress());
  }
  if (arguments.output != standard_output) note(terminal, "wrote " + arguments.output);
  return 0;
}

}  // namespace

Verb convert_verb() {
  auto arguments = std::make_shared<Arguments>();
  return {"convert",
          "Write a recording in another format",
          {{"RECORDING", &arguments->recording, "recording to read; - reads standard input", true},
           {"-o,--output", &arguments->output,
            "recording to write; the end of its name selects the format; - writes CSV to standard\noutput", true},
           topic_argument(arguments->topics),
           reading_sets(arguments->sets)},
          "Examples:\n"
          "  tumble convert data.csv -o data.h5\n"
          "  tumble convert old.csv -o new.csv --set rate=100 --set unit.x=deg/h --set missing=NA\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
