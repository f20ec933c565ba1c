#include "tumble/archive/deposit.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/storage/packing.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

using deposits::ReadResult;
using schema::Change;

/// So many results share a transaction, and with it a synchronisation.
constexpr std::size_t together = 100;

/// A file with its checksum.
struct HashedFile {
  FileDeposit file;
  std::string sha256;
};

/// A deposit that was read and checked.
struct CheckedDeposit {
  std::vector<ReadResult> results;
  std::vector<HashedFile> files;
  std::vector<std::string> certificates;  ///< SHA-256 of each
};

/// What a file is, and of which unit, as the results say that were made from it.
bool name_by_results(HashedFile& file, const std::vector<ReadResult>& results, database::Database& database) {
  for (const ReadResult& result : results)
    for (const auto& [role, sha256, name] : deposits::inputs_of(result.estimate))
      if (sha256 == file.sha256) {
        file.file.unit = result.unit;
        if (file.file.role.empty()) file.file.role = role;
        return true;
      }
  for (const auto& row : database.ask("SELECT u.model, u.serial, i.role FROM inputs i JOIN results r ON r.id = "
                                      "i.result JOIN units u ON u.id = r.unit "
                                      "WHERE i.sha256 = ? ORDER BY r.moment LIMIT 1",
                                      {file.sha256})) {
    file.file.unit = {database::text(row, 0), database::text(row, 1)};
    if (file.file.role.empty()) file.file.role = database::text(row, 2);
    return true;
  }
  return false;
}

void check_correction(ReadResult& result, database::Database& database, const ArchiveAct& act, Problems& problems) {
  const std::string& old = result.deposit->corrects;
  if (old.empty() || result.sha256.empty()) return;
  const std::string& file = result.deposit->file;
  const std::int64_t id = schema::number_of(old);
  if (act.why.empty()) problems.push_back(say("{}: a correction needs a reason: --reason TEXT", Name{file}));
  if (old == result.sha256) problems.push_back(say("{}: a result cannot replace itself", Name{file}));
  const auto rows = database.ask("SELECT unit FROM results WHERE id = ?", {id});
  if (rows.empty())
    problems.push_back(
        say("{}: the result {} that it replaces is not in the archive", Name{file}, Name{first_digits(old)}));
  else if (database::integer(rows[0], 0) != schema::number_of(deposits::sha256_of_unit(result.unit)))
    problems.push_back(
        say("{}: the result {} that it replaces is of another unit", Name{file}, Name{first_digits(old)}));
  const auto earlier = database.ask("SELECT replaced_by FROM corrections WHERE result = ?", {id});
  if (!earlier.empty() && database::integer(earlier[0], 0) != schema::number_of(result.sha256))
    problems.push_back(say("{}: the result {} was replaced already", Name{file}, Name{first_digits(old)}));
  const auto later = database.ask("SELECT 1 FROM corrections WHERE result = ?", {schema::number_of(result.sha256)});
  if (earlier.empty() && !later.empty())
    problems.push_back(say("{}: this result was replaced or withdrawn itself, and cannot replace {}", Name{file},
                           Name{first_digits(old)}));
  result.corrects = id;
}

void check_files(const Deposit& deposit, CheckedDeposit& checked, database::Database& database, Problems& problems) {
  for (const auto& file : deposit.files) {
    HashedFile hashed{file, sha256_of_file(file.path)};
    for (auto& problem : deposits::problems_of_name(file.unit))
      problems.push_back(say("{}: {}", Name{file.path}, problem));
    const bool named =
        !file.unit.serial.empty() || !file.run.empty() || name_by_results(hashed, checked.results, database);
    if (!named)
      problems.push_back(say("{}: no result was made from this file: give --unit MODEL/SERIAL, or the result with it",
                             Name{file.path}));
    if (hashed.file.role.empty()) hashed.file.role = "recording";
    checked.files.push_back(std::move(hashed));
  }
}

CheckedDeposit checked(const Deposit& deposit, database::Database& database, const ArchiveAct& act) {
  Problems problems;
  if (act.who.empty()) problems.emplace_back("--by NAME is missing: an archive keeps who did what");
  CheckedDeposit all;
  for (const auto& result : deposit.results) {
    all.results.push_back(deposits::read_result(result, problems));
    check_correction(all.results.back(), database, act, problems);
  }
  check_files(deposit, all, database, problems);
  for (const auto& certificate : deposit.certificates) {
    all.certificates.push_back(sha256_of_file(certificate.path));
    if (auto problem = deposits::problem_of_number(database, certificate, all.certificates.back()); !problem.empty())
      problems.push_back(std::move(problem));
    const bool with = std::ranges::find(all.results, certificate.result, &ReadResult::sha256) != all.results.end();
    if (!with && database.ask("SELECT 1 FROM results WHERE id = ?", {schema::number_of(certificate.result)}).empty())
      problems.push_back(say("{}: its result {} is not in the archive: put it in first", Name{certificate.path},
                             Name{first_digits(certificate.result)}));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return all;
}

/// Runs `put` for `count` things, `together` in each transaction; counts those that were new.
std::size_t in_batches(database::Database& database, const ArchiveAct& act, std::size_t count, std::size_t& known,
                       const std::function<bool(Change&, std::size_t)>& put) {
  std::size_t fresh = 0;
  for (std::size_t begin = 0; begin < count; begin += together) {
    const std::size_t end = std::min(count, begin + together);
    std::size_t of_batch = 0;
    database.transact([&] {
      of_batch = 0;
      Change change(database, act.who, act.when);
      for (std::size_t i = begin; i < end; ++i) of_batch += put(change, i) ? 1 : 0;
    });
    fresh += of_batch;
    known += end - begin - of_batch;
  }
  return fresh;
}

bool put_correction(Change& change, const ReadResult& result, const std::string& why) {
  if (!result.corrects ||
      !change.database().ask("SELECT 1 FROM corrections WHERE result = ?", {*result.corrects}).empty())
    return false;
  change.append(schema::chain_of_unit(result.unit.model, result.unit.serial),
                {"correction", result.deposit->corrects, why, result.sha256},
                {{&schema::corrections,
                  {{*result.corrects, schema::number_of(result.sha256), why, change.who(), change.when()}}}});
  return true;
}

/// Order of the chains, so that writers at once wait for each other and do not lock each other.
std::vector<const ReadResult*> by_unit(const std::vector<ReadResult>& results) {
  std::vector<const ReadResult*> sorted;
  for (const auto& result : results) sorted.push_back(&result);
  std::ranges::stable_sort(sorted, {},
                           [](const ReadResult* one) { return std::tie(one->unit.model, one->unit.serial); });
  return sorted;
}

Deposited put_checked(Archive& archive, const Deposit& deposit, const CheckedDeposit& checked, const ArchiveAct& act) {
  auto& database = schema::opened(archive).database;
  const auto place = schema::opened(archive).files();
  Deposited done;
  for (const auto& [file, sha256] : checked.files) storage::keep(place, file.path);
  for (const auto& certificate : deposit.certificates) storage::keep(place, certificate.path);
  done.equipment = in_batches(database, act, deposit.equipment.size(), done.known, [&](Change& change, std::size_t i) {
    return deposits::put_equipment(change, deposit.equipment[i]);
  });
  done.runs = in_batches(database, act, deposit.runs.size(), done.known,
                         [&](Change& change, std::size_t i) { return deposits::put_run(change, deposit.runs[i]); });
  const auto results = by_unit(checked.results);
  done.results = in_batches(database, act, results.size(), done.known, [&](Change& change, std::size_t i) {
    const bool fresh = deposits::put_result(change, *results[i]);
    return put_correction(change, *results[i], act.why) || fresh;
  });
  done.files = in_batches(database, act, checked.files.size(), done.known, [&](Change& change, std::size_t i) {
    const auto& [file, sha256] = checked.files[i];
    return deposits::put_file(change, file, sha256, static_cast<std::int64_t>(fs::file_size(file.path)));
  });
  done.certificates =
      in_batches(database, act, deposit.certificates.size(), done.known, [&](Change& change, std::size_t i) {
        return deposits::put_certificate(change, deposit.certificates[i], checked.certificates[i]);
      });
  for (const auto& result : checked.results) done.result_ids.push_back(result.sha256);
  return done;
}

}  // namespace

Deposited put_in(Archive& archive, const Deposit& deposit, const ArchiveAct& act) {
  return schema::guarded(archive.address(), [&] {
    const CheckedDeposit all = checked(deposit, schema::opened(archive).database, act);
    return put_checked(archive, deposit, all, act);
  });
}

}  // namespace tumble
