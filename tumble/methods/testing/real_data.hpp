#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

/// For the tests that compare with recordings of others (label "data").
namespace tumble {

/// Where script/data puts the file of that name (script/data.txt).
inline std::string real_data(const std::string& name) { return TUMBLE_SOURCE_DIR "/out/data/" + name; }

/// A sentence for GTEST_SKIP when one of these files is absent; empty: all are there.
inline std::string absent(std::initializer_list<std::string> names) {
  for (const auto& name : names)
    if (!std::filesystem::exists(real_data(name))) return name + " is absent: script/data fetches it";
  return "";
}

}  // namespace tumble
