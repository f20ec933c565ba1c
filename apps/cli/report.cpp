#include "tumble/report/report.hpp"

#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "verbs.hpp"

namespace tumble::cli {

Verb add_report(CLI::App& program) {
  struct Arguments {
    std::string result, output;
  };
  auto* app = program.add_subcommand("report", "Write a result as one HTML page that needs no network");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("RESULT", arguments->result, "result (.json) of identify or predict")->required();
  app->add_option("-o,--output", arguments->output, "page to write (.html)")->required();
  app->footer("Example:\n  tumble report fog.json -o fog.html\n");
  return {app, [arguments](const Terminal& terminal) {
            check_output(arguments->output, {arguments->result}, {".html", ".htm"});
            write_file_atomically(arguments->output, to_html(read_result(arguments->result)));
            note(terminal, "wrote " + arguments->output);
            return 0;
          }};
}

}  // namespace tumble::cli
