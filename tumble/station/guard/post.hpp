#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tumble/station/guard.hpp"

namespace tumble::guard {

/// Memory of both processes.
struct Shared {
  std::atomic<std::uint64_t> looks{0};
  std::atomic<bool> armed{false}, dismissed{false}, acted{false};
};

/// A link that was opened again, or lost: its file follows in the message.
struct Change {
  std::size_t wire = 0;
};

/// Data of the guard when it begins. They are made before the process is, and only read afterwards: the process of a
/// run has threads, so that its child may neither allocate nor lock.
struct Post {
  Shared* shared = nullptr;
  int line = -1;                 ///< to the process of the run
  int note = -1;                 ///< the file of what it does; its lock says that the guard is there
  std::vector<int> descriptors;  ///< by wire
  std::vector<GuardOrder> orders;
  std::vector<std::string> words;  ///< by order: "stop to bench"
  std::vector<int> kept;           ///< room for the files that stay open
  double patience = 0.0;           ///< [s]
  std::size_t own_name = 0;        ///< [byte] of the command line of the process, which is another for its guard
};

/// The life of the guard, in its own process.
[[noreturn]] void keep_watch(Post& post);

}  // namespace tumble::guard
