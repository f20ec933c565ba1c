#include "services.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "readers.hpp"
#include "tumble/archive/deposit.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/serve/workbench.hpp"
#include "tumble/station/station_file.hpp"

namespace tumble::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* now = "2026-03-02T09:00:00Z";

/// Routes that only look, and those that read a body: no job is begun, since that starts a program.
const std::vector<std::string>& routes() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> some = workbench_routes();
    std::erase_if(some, [](const std::string& route) {
      return route.find("/api/jobs") != route.npos || route.find("/api/runs") != route.npos ||
             route.find("/api/stations/") != route.npos || route.find("/api/events") != route.npos;
    });
    return some;
  }();
  return all;
}

/// A folder that lives as long as the process.
struct Folder {
  fs::path path = fs::temp_directory_path() / fmt::format("tumble_fuzz_{}", getpid());

  Folder() {
    fs::create_directories(path);
    std::ofstream(path / "first.json") << to_json(testing::estimate());
    std::ofstream(path / "data.csv") << "time[s],gyro.x[deg/h]\n0,1\n1,2\n2,1\n3,2\n";
    std::ofstream(path / "plan.toml") << "method = \"static_bias\"\n";
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code none;
    fs::remove_all(path, none);
  }
};

Workbench& workbench() {
  static const Folder folder;
  static Workbench bench([] {
    WorkbenchOptions options;
    options.folder = folder.path;
    options.cache = folder.path / "cache";
    options.clock = options.steady = [] { return 1e9; };
    options.port = 8321;
    return options;
  }());
  return bench;
}

/// "a=b&c=d", undecoded: what the parser of the network has made of an address.
std::vector<std::pair<std::string, std::string>> query_of(std::string_view line) {
  std::vector<std::pair<std::string, std::string>> all;
  while (!line.empty()) {
    const std::string_view one = line.substr(0, line.find('&'));
    line.remove_prefix(std::min(line.size(), one.size() + 1));
    const auto equals = std::min(one.find('='), one.size());
    all.emplace_back(one.substr(0, equals), one.substr(std::min(one.size(), equals + 1)));
  }
  return all;
}

}  // namespace

std::string run_station(std::string_view bytes) {
  const auto read = [&](Error::Kind kind) {
    return outcome([&] { return read_station(std::string(bytes), "s.toml"), std::string(); }, kind);
  };
  const auto wrong = read(Error::Kind::bad_input);
  return wrong.empty() || read(Error::Kind::bad_file).empty() ? "" : wrong;
}

std::string run_route(std::string_view bytes) {
  if (bytes.empty()) return "";
  const std::string& route = routes()[static_cast<unsigned char>(bytes[0]) % routes().size()];
  const std::string_view rest = bytes.substr(1), line = rest.substr(0, rest.find('\n'));
  HttpRequest request;
  request.method = route.substr(0, route.find(' '));
  request.path = route.substr(route.find(' ') + 1);
  request.query = query_of(line);
  request.headers = {
      {"host", "127.0.0.1:8321"}, {"origin", "http://127.0.0.1:8321"}, {"content-type", "application/json"}};
  request.body = rest.substr(std::min(rest.size(), line.size() + 1));
  request.body_bytes = request.body.size();
  try {
    const HttpResponse response = workbench().handler().answer(request);
    if (response.status >= 500 && response.status != 501 && response.status != 503)
      return route + ": status " + std::to_string(response.status) + ": " + response.body;
  } catch (const std::exception& error) {
    return route + ": " + error.what();
  }
  return "";
}

std::string run_archive(std::string_view bytes, const std::string& path) {
  const std::string file = path + ".db";
  write_bytes(bytes, file);
  for (const char* beside : {"-wal", "-shm", "-journal"}) fs::remove(file + beside);
  return outcome([&] {
    const Archive archive(file, now);
    for (const auto& unit : archived_units(archive)) unit_record(archive, unit.name);
    verify_archive(archive);
    due_calibrations(archive, "2030-01-01");
    return std::string();
  });
}

std::vector<std::string> seeds_of_routes() {
  std::vector<std::string> seeds;
  for (std::size_t i = 0; i < routes().size(); ++i)
    for (const char* rest : {"file=first.json&unit=bias~deg/s&language=zh\n", "file=data.csv&from=0&to=2&columns=100\n",
                             "\n{\"text\": \"method = 'static_bias'\\n\", \"file\": \"plan.toml\"}"})
      seeds.push_back(std::string(1, static_cast<char>(i)) + rest);
  return seeds;
}

std::vector<std::string> seeds_of_archives(const std::string& path) {
  const std::string file = path + ".seed.db";
  make_archive(file, files_in_database, {"somebody", now, ""});
  {
    Archive archive(file, now);
    Deposit deposit;
    deposit.results.push_back({.json = to_json(testing::estimate()), .file = "r.json", .ended = now});
    put_in(archive, deposit, {"somebody", now, ""});
  }
  const std::string bytes = read_text_file(file);
  fs::remove(file);
  return {bytes};
}

}  // namespace tumble::fuzz
