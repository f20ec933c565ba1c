#include "tumble/station/lease/claim.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

#include "tumble/formats/checksum.hpp"
#include "tumble/recorder/recorder.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::lease {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "tumble-lease/";
constexpr std::array<const char*, 2> folders{"/run/lock/tumble-leases", "/var/tmp/tumble-leases"};

std::string hash_of(const std::string& name) { return first_digits(sha256_of(name), 32); }

/// A socket with this name, which no file is; -1: somebody has it.
int socket_named(const std::string& hash) {
  const std::string name = std::string(prefix) + hash;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const int made = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (made >= 0 && bind(made, reinterpret_cast<const sockaddr*>(&address), size) == 0) return made;
  if (made >= 0) close(made);
  return -1;
}

/// The file of a name in a folder, which all users of the machine share; -1: it cannot be had.
int file_in(const char* folder, const std::string& hash) {
  std::error_code problem;
  if (fs::create_directory(folder, problem)) fs::permissions(folder, fs::perms::all, problem);
  const std::string path = std::string(folder) + "/" + hash;
  int file = open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0 && errno == ENOENT) file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file >= 0) fchmod(file, 0666);  // also for other users; refused where it is theirs
  return file;
}

/// "1234 /lab/run-0173"
Holder holder_in(int file) {
  char bytes[4096];
  const ssize_t count = pread(file, bytes, sizeof bytes, 0);
  const std::string content(bytes, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  Holder holder;
  const auto space = content.find(' ');
  std::from_chars(content.data(), content.data() + std::min(space, content.size()), holder.process);
  if (space != std::string::npos) holder.run = content.substr(space + 1, content.find('\n') - space - 1);
  return holder;
}

bool write_note(int file, const std::string& content) {
  errno = ENOSPC;  // of a part that was written
  const bool written = ftruncate(file, 0) == 0 &&
                       pwrite(file, content.data(), content.size(), 0) == static_cast<ssize_t>(content.size());
  (void)fsync(file);  // what a power cut takes with it is of the other folder, or of a rig without power
  return written;
}

/// The names that are claimed, with the inodes of their sockets.
std::map<std::string, std::string> claimed_names() {
  std::map<std::string, std::string> names;
  std::ifstream list("/proc/net/unix");
  for (std::string line; std::getline(list, line);) {
    const auto at = line.find("@" + std::string(prefix));
    if (at == std::string::npos) continue;
    const std::string before = line.substr(0, line.find_last_not_of(' ', at - 1) + 1);
    names[line.substr(at + 1 + prefix.size())] = before.substr(before.rfind(' ') + 1);
  }
  return names;
}

/// The files that a process has open, by their names; nothing where this user may not see them.
std::vector<std::string> open_files_of(const std::string& process) {
  std::vector<std::string> files;
  std::error_code problem;
  for (fs::directory_iterator entry("/proc/" + process + "/fd", problem), last; !problem && entry != last;
       entry.increment(problem)) {
    std::error_code closed;
    files.push_back(fs::read_symlink(entry->path(), closed).string());
  }
  return files;
}

/// What the kernel says of the processes that this user may look into: inodes of sockets, with process and run.
std::map<std::string, Holder> holders_by_inode(const std::map<std::string, std::string>& names) {
  std::map<std::string, Holder> found;
  std::error_code problem;
  for (fs::directory_iterator entry("/proc", problem), last; !problem && entry != last; entry.increment(problem)) {
    const std::string process = entry->path().filename().string();
    if (process.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto files = open_files_of(process);
    Holder holder{std::atol(process.c_str()), ""};
    for (const std::string& file : files)
      if (const fs::path path(file); path.filename() == live_store_name) holder.run = path.parent_path().string();
    for (const auto& [name, inode] : names)
      if (std::ranges::find(files, "socket:[" + inode + "]") != files.end()) found.try_emplace(inode, holder);
  }
  return found;
}

Holder noted_holder(const std::string& hash) {
  for (const char* folder : folders) {
    const int file = open((std::string(folder) + "/" + hash).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) continue;
    const Holder holder = holder_in(file);
    close(file);
    if (holder.process > 0) return holder;
  }
  return {};
}

/// Whether a process belongs to this user: then the kernel would have shown its sockets.
bool is_of_this_user(long process) {
  struct stat state {};
  return stat(fmt::format("/proc/{}", process).c_str(), &state) == 0 && state.st_uid == geteuid();
}

}  // namespace

Claim::Claim(std::string name) : name_(hash_of(name)) {
  bool is_free = true;
  for (const char* folder : folders) {
    const int file = file_in(folder, name_);
    if (file < 0) continue;
    files_.push_back(file);
    if (const Holder holder = holder_in(file); holder.process != 0 && before_.process == 0) before_ = holder;
    is_free = flock(file, LOCK_EX | LOCK_NB) == 0 && is_free;
  }
  if (is_free) socket_ = socket_named(name_);
  if (socket_ >= 0) return;
  const auto all = holders_by_inode(claimed_names());
  if (const auto names = claimed_names(); names.contains(name_))
    if (const auto true_one = all.find(names.at(name_)); true_one != all.end()) {
      const std::string run = before_.run;
      before_ = true_one->second;
      if (before_.run.empty()) before_.run = run;
    }
  give_up();
}

Claim::Claim(Claim&& other) noexcept
    : name_(std::move(other.name_)),
      socket_(std::exchange(other.socket_, -1)),
      files_(std::exchange(other.files_, {})),
      before_(std::move(other.before_)) {}

Claim::~Claim() { give_up(); }

void Claim::give_up() {
  for (const int file : files_) close(file);
  files_.clear();
  if (socket_ >= 0) close(std::exchange(socket_, -1));
}

void Claim::give_back() {
  for (const int file : files_) (void)write_note(file, "");
}

void Claim::note(const std::string& content) {
  std::string why = "no folder can be written";
  bool any = false;
  for (const int file : files_)
    if (write_note(file, content))
      any = true;
    else
      why = std::strerror(errno);
  if (!any)
    throw Error(Error::Kind::bad_file,
                say("cannot write the lease of a device in {}: {}", fmt::join(folders, " or "), system_reason(why)));
}

std::vector<Holder> holders() {
  const auto names = claimed_names();
  if (names.empty()) return {};
  const auto by_kernel = holders_by_inode(names);
  std::vector<Holder> all;
  for (const auto& [hash, inode] : names) {
    Holder holder = noted_holder(hash);
    if (const auto known = by_kernel.find(inode); known != by_kernel.end()) {
      if (holder.process != known->second.process || holder.run.empty()) holder = known->second;
    } else if (is_of_this_user(holder.process)) {
      holder.process = 0;
    }
    if (holder.run.empty() && holder.process == 0) continue;
    if (holder.run.empty()) holder.run = fmt::format("process {}", holder.process);
    if (std::ranges::find(all, holder.run, &Holder::run) == all.end()) all.push_back(std::move(holder));
  }
  return all;
}

}  // namespace tumble::lease
