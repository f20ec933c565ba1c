#include "serve.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>

#include "archive_options.hpp"
#include "inspect.hpp"
#include "password.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/report/report.hpp"
#include "tumble/serve/folder_paths.hpp"
#include "tumble/serve/passwords.hpp"
#include "tumble/serve/recording_cache.hpp"
#include "tumble/serve/users.hpp"
#include "tumble/serve/workbench.hpp"
#include "tumble/tasks/plan_text.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::cli {
namespace {

namespace fs = std::filesystem;

struct ServeArguments {
  std::string folder = ".", host, port = "8321", certificate, key;
  std::string users, added, changed, predict;
  std::vector<std::string> prepare, sets, roles;
  ArchiveOptions archive;
  bool no_token = false;
  std::uint64_t upload_limit = 10'000'000'000;
};

/// A place of this user alone: by a variable of the XDG directories, or in the home; empty: there is neither.
fs::path place_of_user(const char* variable, const char* in_home) {
  if (const char* place = std::getenv(variable); place && *place) return fs::path(place) / "tumble";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / in_home / "tumble";
  return {};
}

fs::path temporary_place(const char* name) { return fs::temp_directory_path() / fmt::format("{}-{}", name, geteuid()); }

/// A folder of this user alone; empty: it cannot be made there, as in a home that is read only.
fs::path made(const fs::path& path) {
  try {
    return path.empty() ? path : own_folder(path);
  } catch (const Error&) {
    std::error_code none;
    if (fs::exists(fs::symlink_status(path, none))) throw;
    return {};
  }
}

fs::path cache_folder() {
  const fs::path place = made(place_of_user("XDG_CACHE_HOME", ".cache"));
  return place.empty() ? own_folder(temporary_place("tumble-cache")) : place;
}

/// Of a workbench over this folder, and never in the folder: that may come from somebody else. Empty: there is no other
/// place, nothing is kept.
fs::path state_folder(const fs::path& folder) {
  constexpr std::size_t digits = 32;
  for (const fs::path& place : {place_of_user("XDG_STATE_HOME", ".local/state"), temporary_place("tumble-state")}) {
    if (place.empty() || lies_below(with_links_followed(place), folder)) continue;
    if (made(place).empty() || made(place / "workbenches").empty()) continue;
    return own_folder(place / "workbenches" / first_digits(sha256_of(folder.string()), digits));
  }
  return {};
}

double now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

double steady() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

unsigned port_of(const std::string& text) {
  if (const auto port = as_number<unsigned>(text); port && *port <= 65535) return *port;
  throw Error(Error::Kind::bad_input,
              say("--port {}: a number from 0 to 65535 is expected; 0 chooses a free port", Name{text}));
}

bool is_loopback(const std::string& host) { return host == "localhost" || host == "::1" || host.starts_with("127."); }

/// Whether a file that is there lies in a folder, by their true names.
bool lies_in(const std::string& file, const std::string& folder) {
  std::error_code failed;
  if (!fs::exists(file, failed)) return false;
  const auto inside = fs::weakly_canonical(file, failed).lexically_relative(fs::weakly_canonical(folder, failed));
  return !failed && !inside.empty() && !inside.generic_string().starts_with("..");
}

/// What would let others in without a token or read along is refused; the workbench shows texts of its folder.
void check(const ServeArguments& arguments, const std::string& host) {
  Problems problems;
  if (arguments.certificate.empty() != arguments.key.empty()) problems.emplace_back("--cert and --key belong together");
  if (!is_loopback(host) && arguments.certificate.empty())
    problems.push_back(
        say("--host {}: other computers are served by TLS only; give --cert FILE --key FILE", Name{host}));
  if (arguments.no_token && !arguments.users.empty())
    problems.emplace_back("--no-token: with --users everybody signs in");
  if (!is_loopback(host) && arguments.no_token)
    problems.emplace_back("--no-token: only for the computer itself, without --host");
  for (const auto& [option, file] : {std::pair("--users", arguments.users), std::pair("--key", arguments.key)})
    if (!file.empty() && lies_in(file, arguments.folder))
      problems.push_back(say("{} {}: lies in the folder that is shown; keep it elsewhere", option, Name{file}));
  std::error_code failed;
  if (!arguments.users.empty() && !fs::is_regular_file(arguments.users, failed))
    problems.push_back(
        say("--users {}: there is no such file; --add-user NAME --role ROLE makes it", Name{arguments.users}));
  struct stat key {};
  if (!arguments.key.empty() && stat(arguments.key.c_str(), &key) == 0 && (key.st_mode & (S_IWGRP | S_IRWXO)) != 0)
    problems.push_back(say("--key {0}: others may read or write this private key: chmod 600 {0}", Name{arguments.key}));
  if (!fs::is_directory(arguments.folder, failed)) problems.push_back(say("'{}' is no folder", arguments.folder));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// As many connections as the system allows, with descriptors left for files.
std::size_t room_for_connections() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 200;
  const rlim_t wanted = std::min<rlim_t>(limit.rlim_max, 4096);
  if (limit.rlim_cur < wanted) {
    limit.rlim_cur = wanted;
    setrlimit(RLIMIT_NOFILE, &limit);
    getrlimit(RLIMIT_NOFILE, &limit);
  }
  return std::clamp<std::size_t>(static_cast<std::size_t>(limit.rlim_cur), 100, 1000) - 80;
}

std::string name_of_computer() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

int prepare(const ServeArguments& arguments, const Terminal& terminal) {
  const auto inspected = [](const std::string& path, const ReadOptions& options, const Progress& progress) {
    return inspection_json(tumble::inspect(path, options, progress));
  };
  for (const auto& recording : arguments.prepare) {
    ProgressLine line(terminal);
    prepare_recording(recording, parse_sets(arguments.sets), cache_folder(), inspected, line.progress());
  }
  return 0;
}

/// For the workbench, which ends this process when somebody writes on: the plan on standard input as if it stood in the
/// file.
int predict(const ServeArguments& arguments) {
  constexpr rlim_t most = 60;  // [s] of processor time
  const rlimit limit{most, most};
  setrlimit(RLIMIT_CPU, &limit);
  const std::string text{std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
  print(to_json(tumble::predict(plan_of_text(text, arguments.predict))));
  return 0;
}

/// Adds a user, or gives one another password.
int change_users(const ServeArguments& arguments, const Terminal& terminal) {
  Problems problems;
  if (arguments.users.empty()) problems.emplace_back("--users FILE is missing: the file of the users");
  if (!arguments.added.empty() && !arguments.changed.empty())
    problems.emplace_back("either --add-user or --password-of is expected");
  if (arguments.added.empty() == !arguments.roles.empty())
    problems.emplace_back("--add-user and --role belong together: --add-user NAME --role read|operate|approve");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  User user{arguments.added.empty() ? arguments.changed : arguments.added, {}, {}};
  for (const Right right : all_rights())
    if (std::ranges::find(arguments.roles, name(right)) != arguments.roles.end()) user.roles.insert(right);
  const std::string password = new_password(user.name);
  if (const auto wrong = problems_of_password(password, user.name); !wrong.empty())
    throw Error(Error::Kind::bad_input, wrong);
  user.password = hash_of_password(password);
  if (arguments.added.empty())
    change_password(arguments.users, user.name, user.password);
  else
    add_user(arguments.users, user);
  note(terminal, say("wrote {}", Name{arguments.users}));
  return 0;
}

/// The archive, opened once so that what is wrong with it is said at once. Jobs find it in the environment: an address
/// stands in no file of theirs.
std::string archive_of(const ServeArguments& arguments) {
  std::string address = archive_address(arguments.archive);
  if (address.empty()) return address;
  if (address.find("://") == std::string::npos) address = fs::absolute(address).string();
  const Archive archive(address, utc_now());
  setenv("TUMBLE_ARCHIVE", address.c_str(), 1);
  return address;
}

WorkbenchOptions options_of(const ServeArguments& arguments, const std::string& host) {
  WorkbenchOptions options;
  options.folder = fs::canonical(arguments.folder);
  options.cache = cache_folder();
  options.state = state_folder(options.folder);
  options.program = fs::canonical("/proc/self/exe").string();
  options.token = arguments.no_token || !arguments.users.empty() ? "" : random_secret();
  options.host = host;
  options.tls = !arguments.certificate.empty();
  options.computer = name_of_computer();
  options.upload_limit = arguments.upload_limit;
  options.first_event = static_cast<std::uint64_t>(now() * 1e3) * 1000;
  options.clock = now;
  options.steady = steady;
  options.users = arguments.users;
  options.archive = archive_of(arguments);
  options.person = act_of(arguments.archive).who;
  return options;
}

/// The address for people; an address that means every one is written as the name of the computer.
std::string link(const WorkbenchOptions& options, unsigned port) {
  const bool every = options.host == "0.0.0.0" || options.host == "::";
  std::string name = every && !options.computer.empty() ? options.computer : options.host;
  if (name.find(':') != std::string::npos) name = "[" + name + "]";
  return fmt::format("{}://{}:{}/{}", options.tls ? "https" : "http", name, port,
                     options.token.empty() ? "" : "#token=" + options.token);
}

int run(const ServeArguments& arguments, const Terminal& terminal) {
  if (!arguments.prepare.empty()) return prepare(arguments, terminal);
  if (!arguments.predict.empty()) return predict(arguments);
  if (!(arguments.added + arguments.changed).empty() || !arguments.roles.empty())
    return change_users(arguments, terminal);
  const std::string host = arguments.host.empty() ? "127.0.0.1" : arguments.host;
  check(arguments, host);
  const auto options = options_of(arguments, host);
  Workbench workbench(options);
  HttpOptions http{host, port_of(arguments.port), arguments.certificate, arguments.key};
  http.connections = room_for_connections();
  HttpServer server(http, workbench.handler());
  workbench.set_port(server.port());
  print_said(terminal, say("workbench of {}\n  {}\nCtrl+C ends it\n", Name{options.folder.string()},
                           Name{link(options, server.port())}));
  server.run(true);
  note(terminal, "the workbench has ended; unfinished jobs begin again with the next one");
  return 0;
}

/// Where it listens, and who is let in.
std::vector<Argument> address_arguments(ServeArguments& arguments) {
  return {
      {"FOLDER", &arguments.folder, "folder of recordings and plans (default: the current one)"},
      {.name = "--port",
       .value = &arguments.port,
       .description = "port to listen at; 0: any that is free (default: 8321)",
       .type = "NUMBER"},
      {.name = "--host",
       .value = &arguments.host,
       .description =
           "address to listen at, for other computers too; needs --cert and --key\n(default: this computer only)",
       .type = "ADDRESS"},
      {.name = "--cert", .value = &arguments.certificate, .description = "certificate of TLS (PEM)", .type = "FILE"},
      {.name = "--key", .value = &arguments.key, .description = "its private key (PEM)", .type = "FILE"},
      {"--no-token", &arguments.no_token, "everybody on this computer may use it, without the link"}};
}

std::vector<Argument> user_arguments(ServeArguments& arguments) {
  return {
      {.name = "--users",
       .value = &arguments.users,
       .description = "users, who sign in with a password, and their roles;\n(default: everybody who has the link may "
                      "do everything)",
       .type = "FILE"},
      {.name = "--add-user",
       .value = &arguments.added,
       .description = "with --users and --role: add a user to that file, and end; asks for the password",
       .type = "NAME"},
      {.name = "--role",
       .value = &arguments.roles,
       .description = "of --add-user: read, operate (upload, start), approve (sign); repeatable",
       .words = {"read", "operate", "approve"}},
      {.name = "--password-of",
       .value = &arguments.changed,
       .description = "with --users: give a user of that file another password, and end",
       .type = "NAME"}};
}

std::vector<Argument> other_arguments(ServeArguments& arguments) {
  return {archive_argument(arguments.archive),
          {.name = "--upload-limit",
           .value = &arguments.upload_limit,
           .description = "largest file that may be uploaded",
           .type = "SIZE",
           .bytes = "10 GB"},
          {.name = "--prepare",
           .value = &arguments.prepare,
           .description = "prepare this recording for quick views, and end; repeatable",
           .type = "RECORDING"},
          {.name = "--predict",
           .value = &arguments.predict,
           .description = "predict the plan that standard input holds as if it stood in this file, and end",
           .type = "PLAN"},
          reading_sets(arguments.sets, "with --prepare: information that the file")};
}

}  // namespace

Verb serve_verb() {
  auto arguments = std::make_shared<ServeArguments>();
  std::vector<Argument> all = address_arguments(*arguments);
  for (const auto& more : {user_arguments(*arguments), other_arguments(*arguments)})
    all.insert(all.end(), more.begin(), more.end());
  return {"serve", "Open the workbench over a folder in a browser", std::move(all),
          "Examples:\n"
          "  tumble serve measurements\n"
          "  tumble serve measurements --host 0.0.0.0 --cert lab.pem --key lab.key\n"
          "  tumble serve --users lab-users.toml --add-user \"Li Wei\" --role operate --role approve\n"
          "  tumble serve measurements --users lab-users.toml --archive lab.db\n"
          "  tumble serve --prepare long.h5\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
