#pragma once

#include <memory>

#include "tumble/recorder/testing/disk_state.hpp"

struct sqlite3_vfs;

namespace tumble::testing {

/// The system's VFS of SQLite behind a DiskState: registered as long as this lives.
class DiskVfs {
 public:
  explicit DiskVfs(DiskState& state);
  DiskVfs(const DiskVfs&) = delete;
  DiskVfs& operator=(const DiskVfs&) = delete;
  ~DiskVfs();
  const char* name() const { return name_.c_str(); }

 private:
  struct Unregister {
    void operator()(sqlite3_vfs* vfs) const;
  };
  std::string name_;
  std::unique_ptr<sqlite3_vfs, Unregister> vfs_;
};

}  // namespace tumble::testing
