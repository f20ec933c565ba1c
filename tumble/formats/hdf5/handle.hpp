#pragma once

#include <hdf5.h>

#include <mutex>
#include <string>
#include <utility>

namespace tumble::hdf5 {

/// Owns one identifier of the HDF5 library.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close closer) : id_(id), close_(closer) {}
  /// `problem`: where the destructor stores the reason of a close that failed, unless one is there already. The library
  /// writes some bytes only then, so that a writer must look there before it says that a file is whole. It must live
  /// longer.
  Handle(hid_t id, Close closer, std::string* problem) : id_(id), close_(closer), problem_(problem) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_), problem_(other.problem_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    std::swap(problem_, other.problem_);
    return *this;
  }
  ~Handle();

  /// False when the library could not: for a file, that its last bytes could not be written.
  bool close() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }
  operator hid_t() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
  std::string* problem_ = nullptr;
};

/// While it lives, this thread alone uses the library (which is not made for several) and nothing is printed.
class Session {
 public:
  Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

 private:
  std::unique_lock<std::recursive_mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// The innermost reason the library gives for its last failure.
std::string last_reason();

}  // namespace tumble::hdf5
