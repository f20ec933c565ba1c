#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tumble/serve/http_server.hpp"

namespace tumble {

/// Folders, addresses and rights of a workbench.
struct WorkbenchOptions {
  std::filesystem::path folder;  ///< recordings, plans, results
  std::filesystem::path cache;   ///< of pyramids
  std::filesystem::path state;   ///< of jobs: of this user alone, outside of the folder; empty: nothing is kept
  std::string program;           ///< file of the program, for jobs
  std::string token;             ///< empty: everybody who reaches the server may
  std::string users;             ///< file of users, who sign in; empty: the token decides
  std::string archive;           ///< address of the archive; empty: none
  std::string person;            ///< who acts where there are no users: the login that started the program
  std::string host = "127.0.0.1";
  unsigned port = 0;
  bool tls = false;
  std::string computer;            ///< name of this computer in the network
  std::uint64_t upload_limit = 0;  ///< [bytes] of one file
  std::uint64_t first_event = 1;   ///< a number that no earlier server reached
  std::function<double()> clock;   ///< [s] since 1970-01-01
  std::function<double()> steady;  ///< [s] of a clock that never runs backwards
};

/// The workbench behind a server: pages, recordings, jobs.
class Workbench {
 public:
  /// Jobs that an earlier server left unfinished begin again. Throws Error::bad_file.
  explicit Workbench(const WorkbenchOptions& options);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  HttpHandler handler();
  /// Known only once the server listens.
  void set_port(unsigned port);

  struct State;

 private:
  std::unique_ptr<State> state_;
};

/// Every route: "GET /api/recordings", for the test of the description.
std::vector<std::string> workbench_routes();

}  // namespace tumble
