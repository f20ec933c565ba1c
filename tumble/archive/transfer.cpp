#include "tumble/archive/transfer.hpp"

#include <set>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/transfer/copy.hpp"
#include "tumble/archive/verify.hpp"

namespace tumble {

namespace {

/// The chains that belong to a unit: its own, its model's, and those of its runs and of their equipment.
std::set<std::string> chains_of_unit(database::Database& database, const UnitName& unit) {
  const std::int64_t id = schema::number_of(deposits::sha256_of_unit(unit));
  std::set<std::string> chains{schema::chain_of_unit(unit.model, unit.serial), schema::chain_of_model(unit.model)};
  database.visit("SELECT run FROM run_units WHERE unit = ?", {id},
                 [&](const database::Row& row) { chains.insert(schema::chain_of_run(database::text(row, 0))); });
  database.visit("SELECT e.equipment FROM run_equipment e JOIN run_units u ON u.run = e.run WHERE u.unit = ?", {id},
                 [&](const database::Row& row) { chains.insert(schema::chain_of_equipment(database::text(row, 0))); });
  return chains;
}

/// Files of the unit that came with another one, such as a plan that both were tested by.
void add_other_files(const transfer::Way& way, const UnitName& unit, const std::vector<ArchivedFile>& files) {
  schema::Change change(way.to, way.who, way.when);
  for (const auto& file : files) {
    if (!way.to.ask("SELECT 1 FROM files WHERE sha256 = ?", {file.sha256}).empty()) continue;
    const auto row = way.from.ask(schema::select_all(schema::files) + " WHERE sha256 = ?", {file.sha256}).at(0);
    change.append(schema::chain_of_unit(unit.model, unit.serial), {"file", file.sha256, {}, file.role},
                  {{&schema::files, {row}}});
  }
}

Transferred exported_to(const Archive& archive, const UnitName& unit, Archive& target, const ArchiveAct& act) {
  auto& from = schema::opened(archive);
  auto& to = schema::opened(target);
  const transfer::Way way{from.database, to.database, act.who, act.when, "export"};
  const auto record = unit_record(archive, unit);
  Transferred done;
  std::set<std::string> files;
  for (const auto& file : record.files) files.insert(file.sha256);
  const auto chains = chains_of_unit(from.database, unit);
  for (const auto& chain : chains) files.merge(transfer::files_of_chain(from.database, chain));
  Problems missing;
  for (const auto& sha256 : files) try {
      done.files += transfer::copy_file(from.files(), to.files(), sha256) ? 1 : 0;
    } catch (const Error& error) {
      missing.insert(missing.end(), error.problems.begin(), error.problems.end());
    }
  if (!missing.empty()) throw Error(Error::Kind::bad_file, missing);
  to.database.transact([&] {
    for (const auto& chain : chains) transfer::copy_chain(way, chain, done);
    add_other_files(way, unit, record.files);
  });
  return done;
}

}  // namespace

Transferred export_unit(const Archive& archive, const UnitName& unit, const std::string& path, const ArchiveAct& act) {
  Transferred done;
  const Sentence taken = say("'{}' is there already: an export is never written over it", path);
  schema::make_whole(path, taken, [&](const std::string& file) {
    schema::make_tables(file, files_in_database, act);
    Archive target(file, act.when);
    done = exported_to(archive, unit, target, act);
  });
  return done;
}

Transferred import_archive(Archive& archive, const std::string& address, const ArchiveAct& act,
                           const Progress& progress) {
  if (act.who.empty()) throw Error(Error::Kind::bad_input, "--by NAME is missing: an archive keeps who did what");
  const Archive source(address, act.when);
  const ArchiveCheck check = verify_archive(source);
  if (!check.problems.empty()) {
    auto problems = check.problems;
    for (auto& problem : problems) problem = within(say("{}", Name{schema::shown_address(address)}), problem);
    throw Error(Error::Kind::bad_data, problems);
  }
  return schema::guarded(archive.address(), [&] {
    auto& from = schema::opened(source);
    auto& to = schema::opened(archive);
    const transfer::Way way{from.database, to.database, act.who, act.when, schema::shown_address(address)};
    Transferred done;
    std::set<std::string> chains;
    from.database.visit("SELECT DISTINCT chain FROM events", {},
                        [&](const database::Row& row) { chains.insert(database::text(row, 0)); });
    chains.erase(schema::chain_of_archive);
    double finished = 0.0;
    for (const auto& chain : chains) {
      report(progress, finished++ / static_cast<double>(chains.size()), "importing");
      for (const auto& sha256 : transfer::files_of_chain(from.database, chain))
        done.files += transfer::copy_file(from.files(), to.files(), sha256) ? 1 : 0;
      Transferred of_chain;
      to.database.transact([&] {
        of_chain = {};
        transfer::copy_chain(way, chain, of_chain);
      });
      done.events += of_chain.events, done.results += of_chain.results, done.known += of_chain.known;
    }
    return done;
  });
}

}  // namespace tumble
