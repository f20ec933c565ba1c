#include "tumble/tasks/certificate.hpp"

#include <filesystem>
#include <memory>
#include <optional>

#include "archive_options.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/temporary_folder.hpp"
#include "tumble/language/text.hpp"
#include "tumble/units/error.hpp"
#include "unit_option.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct CertificateArguments {
  std::string result, lab, rule, format, language, accepted, unit, output, validation;
  std::vector<std::string> sets;
  ArchiveOptions archive;
};

/// What the options of the command line replace.
CertificateDetails details_of(const CertificateArguments& arguments) {
  auto sets = parse_sets(arguments.sets);
  if (!arguments.rule.empty()) sets.emplace_back("certificate.rule", arguments.rule);
  if (!arguments.unit.empty()) sets.emplace_back("item.serial", serial_of_unit(arguments.unit));
  if (!arguments.language.empty()) sets.emplace_back("certificate.language", arguments.language);
  CertificateDetails details = load_lab(arguments.lab, sets);
  for (auto& one : details.equipment)
    if (one.accepted_out_of_date.empty()) one.accepted_out_of_date = arguments.accepted;
  return details;
}

/// The certificate, the result that it is on, and the equipment with its calibrations.
Deposit deposit_of(const Certificate& certificate, const CertificateArguments& arguments, const std::string& result,
                   const std::string& path) {
  const CertificateDetails& details = certificate.details;
  Deposit deposit;
  deposit.results.push_back({.json = result, .file = arguments.result});
  CertificateDeposit one{.path = path, .result = certificate.result_sha256};
  one.number = details.number;
  one.language = language_codes().at(static_cast<std::size_t>(details.language));
  one.rule = details.rule ? name(*details.rule) : "";
  one.issued = details.issued ? iso_date(*details.issued) : "";
  for (const auto& person : details.persons)
    if (person.signs && one.issued_by.empty()) one.issued_by = person.name;
  one.equipment = equipment_deposits(details.equipment);
  deposit.certificates.push_back(std::move(one));
  return deposit;
}

/// Puts a certificate into the archive, before it is written: one that the archive refuses is not issued.
Deposited put_in_archive(Archive& archive, const Certificate& certificate, const CertificateArguments& arguments,
                         const std::string& file, const std::string& text, bool dcc) {
  const TemporaryFolder scratch;
  const std::string path = (scratch.path() / (dcc ? "certificate.xml" : "certificate.html")).string();
  write_file_atomically(path, text);
  return put_in(archive, deposit_of(certificate, arguments, read_text_file(file), path), act_of(arguments.archive));
}

int run(const CertificateArguments& arguments, const Terminal& terminal) {
  const bool dcc = arguments.format == "dcc" ||
                   (arguments.format.empty() && std::filesystem::path(arguments.output).extension() == ".xml");
  check_output("-o", arguments.output, {arguments.result, arguments.lab, arguments.validation},
               dcc ? std::vector<std::string>{".xml"} : std::vector<std::string>{".html", ".htm"});
  auto archive = optional_archive(arguments.archive);
  if (archive && arguments.output == standard_output)
    throw Error(Error::Kind::bad_input, "-o -: a certificate that is archived needs a file");
  const std::string file = readable(arguments.result);
  Certificate certificate = certificate_on(file, details_of(arguments), arguments.validation);
  if (arguments.result == "-") certificate.result_file = "standard input";
  const std::string page = certificate_html(certificate);
  const std::string text = dcc ? certificate_dcc(certificate, page) : page;
  std::optional<Deposited> deposited;
  if (archive) deposited = put_in_archive(*archive, certificate, arguments, file, text, dcc);
  write_output(terminal, arguments.output, text);
  if (deposited) note_deposited(terminal, *deposited);
  for (const auto& one : certificate.notes) note(terminal, one);
  if (certificate.estimate.provenance.seed)
    note(terminal, "the data are simulated: the certificate says that it is a specimen");
  return 0;
}

}  // namespace

Verb certificate_verb() {
  auto arguments = std::make_shared<CertificateArguments>();
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
       {"--validation", &arguments->validation,
        "validation of the plan (.json) that `tumble validate` wrote, as an annex"},
       {"--accept-out-of-date", &arguments->accepted,
        "why equipment was used whose calibration ended before the test did; printed", false, "REASON"},
       {"--unit", &arguments->unit,
        "serial number of the unit, as SERIAL or SLOT=SERIAL;\nanother one than that of the recording or result is an "
        "error",
        false, "UNIT"},
       archive_argument(arguments->archive),
       by_argument(arguments->archive),
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
