#pragma once

#include <cstdint>

#include "tumble/recorder/disk.hpp"
#include "tumble/recorder/testing/disk_state.hpp"
#include "tumble/recorder/testing/disk_vfs.hpp"

namespace tumble::testing {

/// A disk that counts the calls and carries out a fault. No database may be open on it when it ends.
class FaultyDisk {
 public:
  explicit FaultyDisk(const DiskFault& fault = {});

  Disk& disk() { return disk_; }
  operator Disk&() { return disk_; }
  std::uint64_t calls() const { return state_.calls(); }
  /// After a crash: changes the files to what the power cut left of them. What was synchronised is there, and a random
  /// part of what was not.
  void power_cut() { state_.power_cut(); }

 private:
  DiskState state_;
  DiskVfs vfs_;
  Disk disk_;
};

}  // namespace tumble::testing
