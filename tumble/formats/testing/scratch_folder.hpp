#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

namespace tumble {

/// For tests: a folder that vanishes with them.
struct ScratchFolder {
  std::filesystem::path path;
  ScratchFolder() {
    static int number = 0;
    path = std::filesystem::temp_directory_path() /
           ("tumble_test_" + std::to_string(getpid()) + "_" + std::to_string(number++));
    std::filesystem::create_directories(path);
  }
  ~ScratchFolder() { std::filesystem::remove_all(path); }
  std::string file(const std::string& name) const { return (path / name).string(); }
  std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()));
  }
};

}  // namespace tumble
