#include "archive_options.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::cli {
namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

std::string utc(std::chrono::system_clock::time_point time, const char* format) {
  return fmt::format(fmt::runtime(std::string("{:") + format + "}"),
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

}  // namespace

Argument archive_argument(ArchiveOptions& options) {
  return {.name = "--archive",
          .value = &options.address,
          .description =
              "archive: a file, or postgresql://USER@HOST/DATABASE\n(default: the environment variable TUMBLE_ARCHIVE)",
          .type = "ARCHIVE"};
}

Argument by_argument(ArchiveOptions& options) {
  return {.name = "--by",
          .value = &options.who,
          .description = "who does this (default: the name of the login)",
          .type = "NAME"};
}

std::string archive_address(const ArchiveOptions& options) {
  return options.address.empty() ? variable("TUMBLE_ARCHIVE") : options.address;
}

Archive open_archive(const ArchiveOptions& options) {
  const std::string address = archive_address(options);
  if (address.empty())
    throw Error(
        Error::Kind::bad_input,
        "--archive ARCHIVE is missing: a file such as lab.db, or postgresql://USER@HOST/DATABASE; the environment "
        "variable TUMBLE_ARCHIVE may name it too");
  return Archive(address, utc_now());
}

std::optional<Archive> optional_archive(const ArchiveOptions& options) {
  if (archive_address(options).empty()) return std::nullopt;
  std::optional<Archive> archive(open_archive(options));
  if (act_of(options).who.empty())
    throw Error(Error::Kind::bad_input, "--by NAME is missing: an archive keeps who did what");
  return archive;
}

bool unit_is_known(const UnitName& unit, const ArchiveOptions& options, const Terminal& terminal) {
  if (!unit.model.empty() && !unit.serial.empty()) return true;
  const Sentence problem =
      "the plan does not say which unit it is: [instrument] model and serial are required to archive the result";
  if (!options.address.empty()) throw Error(Error::Kind::bad_input, say("--archive: {}", problem));
  note(terminal, say("not archived: {}", problem));
  return false;
}

std::vector<EquipmentDeposit> equipment_deposits(const std::vector<Equipment>& equipment) {
  std::vector<EquipmentDeposit> deposits;
  for (const auto& one : equipment) {
    EquipmentDeposit deposit;
    deposit.name = one.name, deposit.maker = one.manufacturer, deposit.model = one.model, deposit.serial = one.serial;
    deposit.certificate = one.certificate, deposit.laboratory = one.traceable_to;
    if (one.due) deposit.due = iso_date(*one.due);
    deposit.document_sha256 = one.certificate_sha256;
    deposits.push_back(std::move(deposit));
  }
  return deposits;
}

ArchiveAct act_of(const ArchiveOptions& options) {
  std::string who = options.who;
  for (const char* const name : {"LOGNAME", "USER"})
    if (who.empty()) who = variable(name);
  return {who, utc_now(), options.why};
}

UnitName unit_name(const std::string& text) {
  if (text.empty()) return {};
  auto name = key_and_value(text, '/');
  if (!name || name->first.empty() || name->second.empty())
    throw Error(Error::Kind::bad_input,
                say("--unit {}: write MODEL/SERIAL, for example --unit triad/0173", Name{text}));
  return {std::move(name->first), std::move(name->second)};
}

void note_deposited(const Terminal& terminal, const Deposited& done) {
  Sentence all;
  const auto add = [&](std::size_t count, const char* singular, const char* plural) {
    if (count == 0) return;
    const Sentence one = say("{} {}", count, count == 1 ? singular : plural);
    all = all.empty() ? one : say("{}, {}", all, one);
  };
  add(done.equipment, "instrument of the laboratory", "instruments of the laboratory");
  add(done.runs, "run", "runs");
  add(done.results, "result", "results");
  add(done.files, "file", "files");
  add(done.certificates, "certificate", "certificates");
  const Sentence known = done.known > 0 ? say("; there already: {}", done.known) : Sentence();
  note(terminal, say("archived {}{}", all.empty() ? Sentence("nothing new") : all, known));
  for (const auto& id : done.result_ids) note(terminal, say("result {}", Name{first_digits(id)}));
}

std::string utc_now() { return utc(std::chrono::system_clock::now(), "%Y-%m-%dT%H:%M:%SZ"); }

std::string utc_day(double seconds) {
  return utc(std::chrono::system_clock::now() + std::chrono::seconds(static_cast<std::int64_t>(seconds)), "%Y-%m-%d");
}

}  // namespace tumble::cli
