#include "tumble/serve/folder_paths.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <nlohmann/json.hpp>

#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse_name(const Sentence& why) { throw Error{Error::Kind::bad_input, say("file: {}", why)}; }

}  // namespace

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

bool is_plain_name(std::string_view name) {
  const auto is_control = [](unsigned char byte) { return byte < 0x20 || byte == 0x7f; };
  if (std::ranges::any_of(name, is_control)) return false;
  try {
    nlohmann::json(std::string(name)).dump();  // throws for what is not UTF-8
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

fs::path inside(const fs::path& root, const std::string& name) {
  if (name.empty()) refuse_name("a name is missing");
  if (!is_plain_name(name)) refuse_name("the name has characters that cannot be shown");
  const fs::path path(name);
  if (path.is_absolute()) refuse_name(say("'{}': a name inside of the folder is expected", name));
  for (const auto& part : path)
    if (part.empty() || is_hidden(part)) refuse_name(say("'{}': a part begins with a dot or is empty", name));
  std::error_code failed;
  const fs::path whole = fs::canonical(root / path, failed);
  if (failed) throw Error{Error::Kind::bad_file, say("there is no '{}' in the folder", name)};
  const fs::path base = fs::canonical(root);
  if (std::mismatch(base.begin(), base.end(), whole.begin(), whole.end()).first != base.end())
    refuse_name(say("'{}': a link leads out of the folder", name));
  return root / path;
}

void require_file_name(const std::string& name) {
  if (name.empty() || name.size() > 200) refuse_name("a name of 1 to 200 bytes is expected");
  if (!is_plain_name(name)) refuse_name("the name has characters that cannot be shown");
  if (name.find_first_of("/\\") != std::string::npos)
    refuse_name(say("'{}': a name without folders is expected", name));
  if (name.front() == '.' || name.front() == '-') refuse_name(say("'{}': the name begins with a dot or a dash", name));
}

double modified_of(const fs::path& path) {
  std::error_code failed;
  const auto time = fs::last_write_time(path, failed);
  if (failed) return 0.0;
  return std::chrono::duration<double>(std::chrono::file_clock::to_sys(time).time_since_epoch()).count();
}

fs::path own_folder(const fs::path& path) {
  std::error_code failed;
  fs::create_directories(path.parent_path(), failed);
  struct stat link {
  }, folder{};
  const bool made = mkdir(path.c_str(), S_IRWXU) == 0 || errno == EEXIST;
  if (!made || lstat(path.c_str(), &link) != 0 || stat(path.c_str(), &folder) != 0 || !S_ISDIR(folder.st_mode))
    throw Error{Error::Kind::bad_file, say("cannot make the folder '{}': {}", path.string(),
                                           system_reason(S_ISREG(folder.st_mode) ? ENOTDIR : errno))};
  if (link.st_uid != geteuid() || folder.st_uid != geteuid())
    throw Error{
        Error::Kind::bad_file,
        say("'{}' belongs to another user: remove it, or name another place (HOME, XDG_CACHE_HOME, XDG_STATE_HOME)",
            path.string())};
  if ((folder.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    throw Error{Error::Kind::bad_file,
                say("others may write into '{}': chmod 700 {}", path.string(), Name{path.string()})};
  return path;
}

FolderClaim::FolderClaim(const fs::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw Error{Error::Kind::bad_input,
              say("another workbench serves '{}': use its link, or end it with Ctrl+C", folder.string())};
}

FolderClaim::~FolderClaim() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace tumble
