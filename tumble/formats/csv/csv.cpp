#include <algorithm>
#include <cstring>
#include <string_view>

#include "tumble/formats/csv/read.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/format.hpp"

namespace tumble::csv {

namespace {

/// Text: no control characters but tabs and line breaks in the first bytes.
bool recognises(const std::string& path) {
  file::InputFile file(path);
  char bytes[4096];
  const std::size_t count = file.read(bytes, sizeof bytes);
  return count > 0 && std::none_of(bytes, bytes + count, [](char c) {
           const auto byte = static_cast<unsigned char>(c);
           return byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r';
         });
}

/// A cell with its separator has about the eight bytes that a value takes.
std::uintmax_t memory(const std::string& path, const ReadOptions&) { return file::InputFile(path).size(); }

}  // namespace

extern const Format csv{"csv",
                        "text table: a header with name[unit] for each column, then one line for each sample",
                        {".csv", ".txt", ".tsv", ".dat"},
                        recognises,
                        tumble::csv::read,
                        memory,
                        tumble::csv::stream,
                        tumble::csv::writer};

}  // namespace tumble::csv
