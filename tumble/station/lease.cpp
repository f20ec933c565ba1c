#include "tumble/station/lease.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>

#include "tumble/formats/checksum.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

/// Shared by all users of the machine, as the devices are.
fs::path folder() {
  const fs::path path = fs::temp_directory_path() / "tumble-leases";
  std::error_code problem;
  fs::create_directories(path, problem);
  fs::permissions(path, fs::perms::all, problem);
  return path;
}

std::string content_of(int file) {
  char bytes[4096];
  const ssize_t count = pread(file, bytes, sizeof bytes, 0);
  return count > 0 ? std::string(bytes, static_cast<std::size_t>(count)) : "";
}

/// "1234 /lab/run-0173"
LeaseHolder holder_of(const std::string& content) {
  LeaseHolder holder;
  const auto space = content.find(' ');
  std::from_chars(content.data(), content.data() + std::min(space, content.size()), holder.process);
  if (space != std::string::npos) holder.run = content.substr(space + 1, content.find('\n') - space - 1);
  return holder;
}

void write_holder(int file, const std::string& content) {
  const auto size = static_cast<ssize_t>(content.size());
  errno = ENOSPC;  // of a part that was written
  if (ftruncate(file, 0) == 0 && pwrite(file, content.data(), content.size(), 0) == size && fsync(file) == 0) return;
  throw Error(Error::Kind::bad_file,
              fmt::format("cannot write the lease of a device in '{}': {}", folder().string(), std::strerror(errno)));
}

/// All links of a station, each once.
std::vector<std::pair<std::string, std::string>> links_of(const Station& station) {
  std::vector<std::pair<std::string, std::string>> links;
  for (const StationDevice& device : station.devices)
    if (!device.link.empty() &&
        std::ranges::find(links, device.link, [](const auto& one) { return one.second; }) == links.end())
      links.emplace_back(device.name, device.link);
  return links;
}

}  // namespace

Lease::Lease(const Station& station, const std::string& run) {
  std::vector<std::string> problems;
  const std::string own = fmt::format("{} {}\n", getpid(), fs::absolute(run).lexically_normal().string());
  for (const auto& [name, link] : links_of(station)) {
    const fs::path path = folder() / sha256_of(link).substr(0, 32);
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) {
      problems.push_back(
          fmt::format("{}: its lease '{}' cannot be opened: {}", name, path.string(), std::strerror(errno)));
      continue;
    }
    fchmod(file, 0666);  // also for other users; refused where it is theirs
    const LeaseHolder before = holder_of(content_of(file));
    if (flock(file, LOCK_EX | LOCK_NB) != 0) {
      problems.push_back(fmt::format("{} at {} is in use by the run '{}' (process {}); tumble stop ends it", name, link,
                                     before.run, before.process));
      close(file);
      continue;
    }
    files_.push_back(file);
    if (before.process != 0) left_.push_back(before);
  }
  if (!problems.empty()) {
    for (const int file : files_) close(file);
    throw Error(Error::Kind::bad_file, problems);
  }
  for (const int file : files_) write_holder(file, own);
}

Lease::~Lease() {
  for (const int file : files_) close(file);
}

void Lease::end() {
  for (const int file : files_) write_holder(file, "");
}

std::vector<LeaseHolder> runs_going_on() {
  std::vector<LeaseHolder> runs;
  std::error_code problem;
  for (fs::directory_iterator entry(folder(), problem), last; !problem && entry != last; entry.increment(problem)) {
    const int file = open(entry->path().c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) continue;
    const LeaseHolder holder = holder_of(content_of(file));
    const bool in_use = flock(file, LOCK_EX | LOCK_NB) != 0;
    close(file);
    if (in_use && holder.process > 0 && std::ranges::find(runs, holder.run, &LeaseHolder::run) == runs.end())
      runs.push_back(holder);
  }
  return runs;
}

}  // namespace tumble
