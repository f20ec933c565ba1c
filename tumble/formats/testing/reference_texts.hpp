#pragma once

#include <string>
#include <vector>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/log_files.hpp"

namespace tumble {

/// For tests: a file of tests/reference/texts.
std::string reference_text(const std::string& name);

/// For tests: begin, begin + 0.125, ... as the files of tests/reference/texts hold them, in SI.
inline std::vector<double> ramp(double begin, std::size_t count, const Unit& unit) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(unit.to_si(begin + 0.125 * static_cast<double>(i)));
  return values;
}

/// For tests: how a file of these bytes is refused; empty: it was read.
inline Refused refusal_of(const std::string& bytes, const std::string& name, const ReadOptions& options = {}) {
  const ScratchFolder folder;
  write_bytes(folder.file(name), bytes);
  return refusal_of(folder.file(name), options);
}

/// For tests: how many of the beginnings of a file are read, the others being refused by an Error with a message.
inline std::size_t beginnings_read(const std::string& path, std::size_t step) {
  const std::string whole = read_text_file(path);
  const auto name = path.substr(path.find_last_of('/') + 1);
  std::size_t read = 0;
  for (std::size_t size = 1; size < whole.size(); size += step) {
    const Refused refused = refusal_of(whole.substr(0, size), name);
    if (refused.empty())
      ++read;
    else
      EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{}, refused)) << size;
  }
  return read;
}

}  // namespace tumble
