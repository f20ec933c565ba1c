#include <memory>

#include "verbs.hpp"

namespace tumble::cli {

Verb add_convert(CLI::App& program) {
  struct Arguments {
    std::string recording, output;
    std::vector<std::string> sets;
  };
  auto* app = program.add_subcommand("convert", "Write a recording in another format");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("RECORDING", arguments->recording, "recording to read")->required();
  app->add_option("-o,--output", arguments->output, "recording to write; the end of its name selects the format")
      ->required();
  add_sets(*app, arguments->sets,
           "information that the file does not contain:\n"
           "rate=100, missing=WORD, unit.COLUMN=deg/h,\n"
           "columns=\"time[s],x[deg/s]\" for a file without a header,\n"
           "segment_column=COLUMN with labels; repeatable");
  app->footer(
      "Examples:\n"
      "  tumble convert data.csv -o data.h5\n"
      "  tumble convert old.csv -o new.csv --set rate=100 --set unit.x=deg/h --set missing=NA\n");
  return {app, [arguments](const Terminal& terminal) {
            check_recording_output(arguments->output, {arguments->recording});
            const auto options = tumble::read_options(parse_sets(arguments->sets));
            {
              ProgressLine line(terminal);
              tumble::convert(arguments->recording, arguments->output, options, line.progress());
            }
            note(terminal, "wrote " + arguments->output);
            return 0;
          }};
}

}  // namespace tumble::cli
