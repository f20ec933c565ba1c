#include "tumble/formats/confinement.hpp"

#include <algorithm>
#include <mutex>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

struct ConfiningFolder {
  std::mutex mutex;
  fs::path path;
};

ConfiningFolder& confining_folder() {
  static ConfiningFolder folder;
  return folder;
}

fs::path exchanged(fs::path folder) {
  auto& kept = confining_folder();
  const std::lock_guard lock(kept.mutex);
  std::swap(kept.path, folder);
  return folder;
}

}  // namespace

/// A folder that is no longer there confines by its name.
Confinement::Confinement(const fs::path& folder) {
  std::error_code absent;
  const fs::path whole = fs::canonical(folder, absent);
  before_ = exchanged(folder.empty() ? fs::path() : absent ? fs::absolute(folder).lexically_normal() : whole);
}

Confinement::~Confinement() { exchanged(before_); }

fs::path confined_to() {
  auto& kept = confining_folder();
  const std::lock_guard lock(kept.mutex);
  return kept.path;
}

bool lies_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

fs::path with_links_followed(const fs::path& path) {
  constexpr int longest_chain = 40;  // as the system has it
  const fs::path whole = fs::absolute(path);
  std::vector<fs::path> ahead(whole.begin(), whole.end());  // the next part is the last
  std::ranges::reverse(ahead);
  fs::path behind;
  for (int links = 0; !ahead.empty();) {
    const fs::path part = ahead.back();
    ahead.pop_back();
    if (part == "..") {
      behind = behind.parent_path();
      continue;
    }
    if (part.empty() || part == ".") continue;
    const fs::path next = behind / part;
    std::error_code none;
    const fs::path target = fs::read_symlink(next, none);
    if (none || ++links > longest_chain) {
      behind = next;
      continue;
    }
    if (target.is_absolute()) behind = target.root_path();
    const fs::path relative = target.relative_path();
    const std::vector<fs::path> parts(relative.begin(), relative.end());
    ahead.insert(ahead.end(), parts.rbegin(), parts.rend());
  }
  return behind;
}

bool may_be_named(const fs::path& path) {
  const fs::path root = confined_to();
  if (root.empty()) return true;
  const fs::path whole = fs::absolute(path).lexically_normal();
  return lies_below(whole, root) && lies_below(with_links_followed(whole), root);
}

std::string file_named_in(const fs::path& folder, const std::string& name) {
  const fs::path path = (folder / name).lexically_normal();
  if (may_be_named(path)) return path.string();
  throw Error(Error::Kind::bad_input,
              say("'{}' lies outside of the folder of the workbench: copy it into the folder", name));
}

void require_contained(const std::string& path) {
  const fs::path root = confined_to();
  if (root.empty()) return;
  const fs::path whole = fs::absolute(path).lexically_normal();
  if (lies_below(whole, root) && !lies_below(with_links_followed(whole), root))
    throw Error(Error::Kind::bad_file, say("'{}' is a link that leads out of the folder of the workbench", path));
}

void require_own_journals(const std::string& database) {
  std::error_code absent, none;
  const fs::path whole = fs::canonical(database, absent);  // as SQLite names them where the database is a link
  for (const char* const end : {"-wal", "-shm", "-journal"}) {
    const auto status = fs::symlink_status((absent ? database : whole.string()) + end, none);
    if (fs::exists(status) && !fs::is_regular_file(status))
      throw Error(Error::Kind::bad_file,
                  say("'{}{}' is a link or a device, not a file: remove it", Name{database}, end));
  }
}

}  // namespace tumble
