#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "archive_actions.hpp"
#include "archive_views.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/transfer.hpp"
#include "tumble/desk/archived_run.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/tasks/certificate.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::cli {
namespace {

namespace fs = std::filesystem;

/// Adds what stands at a path: a result by its extension, the folder of a run, else a file of the results.
void add_path(const std::string& path, const ArchiveArguments& arguments, const UnitName& unit, Deposit& deposit,
              Problems& problems) {
  if (fs::is_directory(path) && is_run_folder(path)) {
    Deposit run = deposit_of_run(path);
    deposit.runs.insert(deposit.runs.end(), run.runs.begin(), run.runs.end());
    deposit.files.insert(deposit.files.end(), run.files.begin(), run.files.end());
  } else if (fs::is_directory(path)) {
    problems.push_back(say("{}: is a folder, and not that of a run; give the files in it", Name{path}));
  } else if (fs::path(path).extension() == ".json") {
    deposit.results.push_back({.json = read_text_file(path), .file = path, .unit = unit, .ended = arguments.date});
  } else if (fs::path(path).extension() == ".html" || fs::path(path).extension() == ".xml") {
    problems.push_back(say("{}: a certificate is archived where it is made: tumble certificate --archive", Name{path}));
  } else {
    deposit.files.push_back({.path = path, .name = fs::path(path).filename().string(), .unit = unit});
  }
}

Deposit deposit_of(const ArchiveArguments& arguments, const Archive& archive) {
  Deposit deposit;
  Problems problems;
  const UnitName unit = unit_name(arguments.unit);
  for (const auto& path : arguments.what) add_path(path, arguments, unit, deposit, problems);
  if (!arguments.lab.empty()) deposit.equipment = equipment_deposits(load_lab(arguments.lab, {}).equipment);
  if (!arguments.replaces.empty()) {
    if (deposit.results.size() != 1)
      problems.emplace_back("--replaces: one result is expected with it, which replaces the other one");
    else
      deposit.results.front().corrects = find_result(archive, arguments.replaces);
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return deposit;
}

void note_transferred(const Terminal& terminal, const std::string& begin, const Transferred& done) {
  const auto word = [](std::size_t count, const char* one, const char* several) {
    return say("{} {}", count, count == 1 ? one : several);
  };
  note(terminal,
       say("{}: {}, {}, {}{}", Name{begin}, word(done.results, "result", "results"), word(done.files, "file", "files"),
           word(done.events, "event", "events"), done.known > 0 ? say("; there already: {}", done.known) : Sentence()));
}

}  // namespace

int archive_init(const ArchiveArguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const std::string address = archive_address(arguments.archive);
  if (address.empty()) open_archive(arguments.archive);  // says what is missing
  make_archive(address, arguments.files, act_of(arguments.archive));
  const Archive archive(address);
  note(terminal, archive.folder().empty() ? Sentence("made the archive; its files will lie in the database")
                                          : say("made the archive; its files will lie in {}", Name{archive.folder()}));
  return 0;
}

int archive_ingest(const ArchiveArguments& arguments, const Terminal& terminal) {
  if (arguments.what.empty() && arguments.lab.empty())
    throw Error(
        Error::Kind::bad_input,
        "archive ingest: files are expected: results (.json), recordings, plans, folders of runs; or --lab LAB");
  Archive archive = open_archive(arguments.archive);
  note_deposited(terminal, put_in(archive, deposit_of(arguments, archive), act_of(arguments.archive)));
  return 0;
}

int archive_note(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& about = only_word(arguments, "UNIT|INSTRUMENT|MODEL");
  Archive archive = open_archive(arguments.archive);
  put_note(archive, {.about = about, .kind = arguments.kind, .text = arguments.text, .when = arguments.date},
           act_of(arguments.archive));
  note(terminal, say("noted of {}: {}", Name{about}, Name{arguments.kind}));
  return 0;
}

int archive_withdraw(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& digits = only_word(arguments, "RESULT");
  Archive archive = open_archive(arguments.archive);
  const std::string sha256 = find_result(archive, digits);
  withdraw_result(archive, sha256, act_of(arguments.archive));
  note(terminal, say("result {} does not count any more", Name{first_digits(sha256)}));
  return 0;
}

int archive_export(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& words = only_word(arguments, "SERIAL");
  if (arguments.output.empty())
    throw Error(Error::Kind::bad_input, "archive export: -o FILE is missing, such as -o unit-0173.db");
  const Archive archive = open_archive(arguments.archive);
  const auto done = export_unit(archive, find_unit(archive, words), arguments.output, act_of(arguments.archive));
  note_transferred(terminal, "wrote " + arguments.output, done);
  return 0;
}

int archive_import(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& from = only_word(arguments, "FILE");
  Archive archive = open_archive(arguments.archive);
  Transferred done;
  {
    ProgressLine line(terminal);
    done = import_archive(archive, from, act_of(arguments.archive), line.progress());
  }
  note_transferred(terminal, "imported", done);
  return 0;
}

}  // namespace tumble::cli
