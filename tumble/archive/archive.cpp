#include "tumble/archive/archive.hpp"

#include <filesystem>
#include <regex>

#include "tumble/archive/schema/chain.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/formats/new_file.hpp"
#include "tumble/version.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

using schema::shown_address;

/// Of a symbolic link the folder beside the file that it names: all names of an archive lead to one folder.
std::string folder_beside(const std::string& address) {
  const fs::path path = fs::is_symlink(address) ? fs::canonical(address) : fs::path(address);
  return fs::path(path).replace_extension(".files").string();
}

/// The fact `files` of an archive whose files lie in the database itself.
constexpr const char* inside = ":database:";

std::string folder_of_files(database::Database& database, const std::string& address) {
  for (const auto& row : database.ask("SELECT value FROM facts WHERE name = 'files'"))
    return database::text(row, 0) == inside ? "" : database::text(row, 0);
  return folder_beside(address);
}

void make_folder_of_files(const std::string& folder) {
  if (folder == files_in_database) return;
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem)
    throw Error(Error::Kind::bad_file, say("cannot make the folder '{}': {}", folder, system_reason(problem)));
}

schema::OpenArchive* open_at(const std::string& address, const std::string& when) {
  if (!database::is_server(address) && !fs::exists(address))
    throw Error(Error::Kind::bad_input,
                say("there is no archive '{0}'; `tumble archive init --archive {0}` makes one", Name{address}));
  return schema::guarded(address, [&] {
    database::Database database(address, false);
    const auto version = schema::version_of(database);
    if (version == 0)
      throw Error(Error::Kind::bad_file, say("'{}' holds no archive of Tumble", shown_address(address)));
    if (version > schema::newest_version())
      throw Error(
          Error::Kind::bad_file,
          say("archive '{}' has version {} of the tables, and this program knows them up to {}: use a newer one",
              shown_address(address), version, schema::newest_version()));
    schema::migrate(database, version, {"Tumble", when, std::string(tumble::version)});
    std::string folder = folder_of_files(database, address);
    return new schema::OpenArchive{address, std::move(folder), std::move(database)};
  });
}

}  // namespace

namespace schema {

OpenArchive& opened(const Archive& archive) { return *static_cast<OpenArchive*>(archive.opened()); }

std::string shown_address(const std::string& address) {
  static const std::regex password("(://[^:/@]*):[^@/]*@");
  return std::regex_replace(address, password, "$1:...@");
}

}  // namespace schema

namespace schema {

void make_tables(const std::string& address, const std::string& folder, const ArchiveAct& act) {
  database::Database database(address, true);
  if (version_of(database) != 0)
    throw Error(Error::Kind::bad_input, say("'{}' holds an archive already", shown_address(address)));
  const bool within = folder == files_in_database;
  migrate(database, 0, {act.who, act.when, std::string(tumble::version)});
  database.transact([&] {
    Change change(database, act.who, act.when);
    const auto note = [&](const std::string& name, const std::string& value) {
      change.append(chain_of_archive, {"fact", name, {}, {}}, {{&facts, {{name, value}}}});
    };
    if (within) note("files", inside);
    if (!within && !folder.empty()) note("files", fs::absolute(folder).lexically_normal().string());
    note("made_by", act.who);
    note("made", act.when);
  });
}

void make_whole(const std::string& path, const Sentence& taken,
                const std::function<void(const std::string& file)>& make) {
  if (NewFile::is_taken(path)) throw Error(Error::Kind::bad_input, taken);
  NewFile file(path);
  try {
    guarded(path, [&] { make(file.temporary()); });
    if (!file.keep()) throw Error(Error::Kind::bad_input, taken);
  } catch (...) {
    std::error_code ignored;
    fs::remove(file.temporary() + "-journal", ignored);
    throw;
  }
}

}  // namespace schema

void Archive::Close::operator()(void* opened) const { delete static_cast<schema::OpenArchive*>(opened); }

Archive::Archive(const std::string& address, const std::string& when) : opened_(open_at(address, when)) {}
const std::string& Archive::address() const { return schema::opened(*this).address; }
const std::string& Archive::folder() const { return schema::opened(*this).folder; }

void make_archive(const std::string& address, const std::string& folder, const ArchiveAct& act) {
  const bool server = database::is_server(address);
  if (server && folder.empty())
    throw Error(Error::Kind::bad_input,
                "--files is required for an archive on a server: the folder of its files, which all who use the "
                "archive see under this name; or the word `database`, to keep them on the server");
  const bool within = folder == files_in_database;
  if (server) {
    make_folder_of_files(folder);
    schema::guarded(address, [&] { schema::make_tables(address, folder, act); });
    return;
  }
  const Sentence taken = say("'{}' is there already: an archive is never written over another file", address);
  schema::make_whole(address, taken, [&](const std::string& file) {
    make_folder_of_files(within || !folder.empty() ? folder : folder_beside(address));
    schema::make_tables(file, folder, act);
  });
}

}  // namespace tumble
