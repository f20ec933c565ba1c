#pragma once

#include <memory>

#include "tumble/station/disk/state.hpp"

struct sqlite3_vfs;

namespace tumble::disk {

/// The system's VFS of SQLite behind a State: registered as long as this lives.
class Vfs {
 public:
  explicit Vfs(State& state);
  Vfs(const Vfs&) = delete;
  Vfs& operator=(const Vfs&) = delete;
  ~Vfs();
  const char* name() const { return name_.c_str(); }

 private:
  struct Unregister {
    void operator()(sqlite3_vfs* vfs) const;
  };
  std::string name_;
  std::unique_ptr<sqlite3_vfs, Unregister> vfs_;
};

}  // namespace tumble::disk
