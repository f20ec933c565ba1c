#include "tumble/report/report.hpp"

#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct Arguments {
  std::string result, output;
};

int run(const Arguments& arguments, const Terminal& terminal) {
  check_output(arguments.output, {arguments.result}, {".html", ".htm"});
  write_file_atomically(arguments.output, to_html(read_result(arguments.result)));
  note(terminal, "wrote " + arguments.output);
  return 0;
}

}  // namespace

Verb report_verb() {
  auto arguments = std::make_shared<Arguments>();
  return {"report",
          "Write a result as one HTML page that needs no network",
          {{"RESULT", &arguments->result, "result (.json) of identify or predict", true},
           {"-o,--output", &arguments->output, "page to write (.html)", true}},
          "Example:\n  tumble report fog.json -o fog.html\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
