#include "tumble/archive/testing/postgres_server.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "tumble/archive/database/database.hpp"

namespace tumble::testing {

namespace fs = std::filesystem;

namespace {

/// Folder of the programs of the newest version; empty: none is installed.
std::string postgres_programs() {
  std::string newest;
  std::error_code none;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", none))
    if (fs::exists(version.path() / "bin/initdb") && fs::exists(version.path() / "bin/postgres"))
      newest = std::max(newest, (version.path() / "bin").string());
  return newest;
}

/// Runs a program of the server as a user that is not root. Throws with its output where it fails.
void run_as_nobody(const std::string& folder, const std::string& command) {
  const std::string user = geteuid() == 0 ? "setpriv --reuid=nobody --regid=nogroup --clear-groups " : "";
  const std::string line =
      fmt::format("cd {0} && {1}{2}/{3} > {0}/output 2>&1", folder, user, postgres_programs(), command);
  if (std::system(line.c_str()) != 0) {
    std::system(fmt::format("cat {}/output >&2", folder).c_str());
    throw std::runtime_error("cannot run: " + line);
  }
}

}  // namespace

bool PostgresServer::installed() { return !postgres_programs().empty(); }

/// Nothing is synchronised to the disk: the tests of this server do not cut the power.
PostgresServer::PostgresServer() {
  std::string name = (fs::temp_directory_path() / "tumble_pg_XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
  folder_ = name;
  fs::permissions(folder_, fs::perms::all);
  run_as_nobody(folder_, fmt::format("initdb -D {}/data -A trust -U tumble -E UTF8 --locale=C --no-sync", folder_));
  run_as_nobody(folder_, fmt::format("pg_ctl -D {0}/data -w -o \"-k {0} -c listen_addresses='' -c fsync=off -c "
                                     "max_connections=50 -c shared_buffers=32MB\" -l {0}/log start",
                                     folder_));
}

PostgresServer::~PostgresServer() {
  try {
    run_as_nobody(folder_, fmt::format("pg_ctl -D {}/data -w -m immediate stop", folder_));
  } catch (const std::exception&) {
    return;  // the folder shows why
  }
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string PostgresServer::address(const std::string& database) const {
  return fmt::format("postgresql://tumble@/{}?host={}", database, folder_);
}

std::string PostgresServer::new_database(const std::string& name) {
  database::Database server(address("postgres"), false);
  server.script("CREATE DATABASE " + name);
  return address(name);
}

}  // namespace tumble::testing
