#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tumble::jobs {

/// A descriptor that is closed with it; -1: none.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();

  int number() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }

 private:
  int number_;
};

/// The folder that lies so many parts below `root`; none where one is not there, or is a link.
Descriptor folder_below(const std::string& root, const std::vector<std::string>& parts);

/// Makes the folder ROOT/PLACE/NAME, which must be new, and ROOT/PLACE where it is not there; no link is followed.
/// Returned: false, there is one of that name. Throws std::filesystem::filesystem_error.
bool make_folder_below(const std::string& root, const std::string& place, const std::string& name);

/// A number that another folder of this file system does not have; 0: it cannot be read.
std::uint64_t number_of(const Descriptor& folder);

/// A file in a folder that is not a link; an empty descriptor without such a file.
Descriptor file_in(const Descriptor& folder, const std::string& name);

/// The regular files in a folder, no links, in the order of their names.
std::vector<std::string> files_in(const Descriptor& folder);

}  // namespace tumble::jobs
