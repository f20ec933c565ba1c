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
  Refused refusal(const std::string& content) const { return refusal_of(file(content), options); }
  /// Whether the table is refused with such a problem, or with such problems.
  ::testing::AssertionResult refuses(const std::string& content, const Asked& asked) const {
    return tumble::refuses(Error::Kind::bad_file, asked, refusal(content));
  }
  ::testing::AssertionResult refuses_with(const std::string& content, const std::vector<Asked>& all) const {
    return tumble::refuses(Error::Kind::bad_file, all, refusal(content));
  }
};

/// For tests: each part stands in the text.
inline void expect_holds(const std::string& text, const std::vector<std::string>& parts) {
  for (const auto& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << "\nin: " << text;
}

}  // namespace tumble
