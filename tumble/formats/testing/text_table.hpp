#pragma once

#include "tumble/formats/testing/log_files.hpp"

namespace tumble {

/// For tests: text tables that are written to one file, read and refused with `options`.
struct TextTable : testing::Test {
  ScratchFolder folder;
  ReadOptions options;

  std::string file(const std::string& content) const {
    write_bytes(folder.file("a.csv"), content);
    return folder.file("a.csv");
  }
  Recording read(const std::string& content) const { return read_recording(file(content), options, {}); }
  std::string refusal(const std::string& content) const {
    const std::string message = refusal_of(file(content), options);
    EXPECT_NE(message, "") << "not refused: " << content;
    return message;
  }
};

/// For tests: each part stands in the text.
inline void expect_holds(const std::string& text, const std::vector<std::string>& parts) {
  for (const auto& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << "\nin: " << text;
}

}  // namespace tumble
