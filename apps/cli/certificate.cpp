#include "tumble/tasks/certificate.hpp"

#include <memory>

#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct Arguments {
  std::string result, lab, rule, format, language, accepted, output;
  std::vector<std::string> sets;
};

/// What the options of the command line replace.
CertificateDetails details_of(const Arguments& arguments) {
  auto sets = parse_sets(arguments.sets);
  if (!arguments.rule.empty()) sets.emplace_back("certificate.rule", arguments.rule);
  if (!arguments.language.empty()) sets.emplace_back("certificate.language", arguments.language);
  CertificateDetails details = load_lab(arguments.lab, sets);
  for (auto& one : details.equipment)
    if (one.accepted_out_of_date.empty()) one.accepted_out_of_date = arguments.accepted;
  return details;
}

int run(const Arguments& arguments, const Terminal& terminal) {
  const bool dcc = arguments.format == "dcc" || (arguments.format.empty() && arguments.output.ends_with(".xml"));
  check_output(arguments.output, {arguments.result, arguments.lab},
               dcc ? std::vector<std::string>{".xml"} : std::vector<std::string>{".html", ".htm"});
  Certificate certificate = certificate_on(readable(arguments.result), details_of(arguments));
  if (arguments.result == "-") certificate.result_file = "standard input";
  const std::string page = certificate_html(certificate);
  write_output(terminal, arguments.output, dcc ? certificate_dcc(certificate, page) : page);
  for (const auto& one : certificate.notes) note(terminal, one);
  if (certificate.estimate.provenance.seed)
    note(terminal, "the data are simulated: the certificate says that it is a specimen");
  return 0;
}

}  // namespace

Verb certificate_verb() {
  auto arguments = std::make_shared<Arguments>();
  return {
      "certificate",
      "Write a calibration certificate: a page to print, or a Digital Calibration Certificate (DCC)",
      {{"RESULT", &arguments->result, "result (.json) of identify; - reads standard input", true},
       {"--lab", &arguments->lab, "what the laboratory says (.toml): see examples/lab.toml", true, "LAB"},
       {"--rule", &arguments->rule,
        "decision rule for the limits of the plan:\nsimple, guarded:FACTOR, risk:PROBABILITY,\nmethod6, non-binary",
        false, "RULE"},
       {"--format",
        &arguments->format,
        "html, or dcc (default: by the name of the output)",
        false,
        "",
        {"html", "dcc"}},
       {"--language", &arguments->language, "of the certificate", false, "", {"en", "zh"}},
       {"--accept-out-of-date", &arguments->accepted,
        "why equipment was used whose calibration ended before the test did; printed", false, "REASON"},
       sets_argument(arguments->sets,
                     "value in place of one of LAB: certificate.number=2026-7, customer.name=...; repeatable"),
       {"-o,--output", &arguments->output, "certificate to write (.html, .xml); - writes to standard output", true}},
      "Examples:\n"
      "  tumble certificate result.json --lab lab.toml -o certificate.html\n"
      "  tumble certificate result.json --lab lab.toml --rule guarded:1 -o certificate.xml\n"
      "  tumble certificate result.json --lab lab.toml --language zh --set certificate.number=2026-8 -o zh.html\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
