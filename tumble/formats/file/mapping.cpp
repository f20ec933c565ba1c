#include "tumble/formats/file/mapping.hpp"

#ifdef __linux__
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#endif

#include <utility>

namespace tumble::file {

namespace {

constexpr std::uint64_t whole_page = std::uint64_t{1} << 16;  // [bytes] a multiple of the page of any system

#if defined __linux__ && defined F_SETSIG && defined F_SETLEASE
bool take_lease(int descriptor) {
  // Who waits for the file is announced by a signal that is ignored unless a program asks for it.
  return fcntl(descriptor, F_SETSIG, SIGURG) == 0 && fcntl(descriptor, F_SETLEASE, F_RDLCK) == 0;
}
bool lease_holds(int descriptor) { return fcntl(descriptor, F_GETLEASE) == F_RDLCK; }
void give_lease_back(int descriptor) { fcntl(descriptor, F_SETLEASE, F_UNLCK); }
#else
bool take_lease(int) { return false; }
bool lease_holds(int) { return false; }
void give_lease_back(int) {}
#endif

}  // namespace

Lease::Lease(std::shared_ptr<const InputFile> file) : file_(std::move(file)) {
  held_ = file_ && take_lease(file_->descriptor());
}

Lease::~Lease() {
  if (held_) give_lease_back(file_->descriptor());
}

bool Lease::holds() {
  if (held_ && !lease_holds(file_->descriptor())) {
    give_lease_back(file_->descriptor());
    held_ = false;
  }
  return held_;
}

Mapping::Mapping([[maybe_unused]] const InputFile& file, [[maybe_unused]] std::uint64_t offset,
                 [[maybe_unused]] std::size_t count) {
#if defined __linux__ && defined MADV_POPULATE_READ
  begin_ = offset / whole_page * whole_page;
  length_ = static_cast<std::size_t>(offset - begin_) + count;
  if (count == 0 || offset + count > file.size()) return;
  void* const pages = mmap(nullptr, length_, PROT_READ, MAP_SHARED, file.descriptor(), static_cast<off_t>(begin_));
  if (pages == MAP_FAILED) return;
  // Brings all pages, and fails where one cannot be read, which else ends the program that touches it.
  if (madvise(pages, length_, MADV_POPULATE_READ) == 0)
    pages_ = pages;
  else
    munmap(pages, length_);
#endif
}

Mapping::Mapping(Mapping&& other) noexcept
    : pages_(std::exchange(other.pages_, nullptr)), length_(other.length_), begin_(other.begin_) {}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(pages_, other.pages_);
  std::swap(length_, other.length_);
  std::swap(begin_, other.begin_);
  return *this;
}

Mapping::~Mapping() {
#ifdef __linux__
  if (pages_ != nullptr) munmap(pages_, length_);
#endif
}

const char* Mapping::at(std::uint64_t offset) const {
  const bool inside = pages_ != nullptr && offset >= begin_ && offset - begin_ < length_;
  return inside ? static_cast<const char*>(pages_) + (offset - begin_) : nullptr;
}

}  // namespace tumble::file
