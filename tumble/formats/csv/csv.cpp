#include <string_view>

#include "tumble/formats/csv/encoding.hpp"
#include "tumble/formats/csv/read.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/kinds_of_text.hpp"
#include "tumble/formats/format.hpp"

namespace tumble::csv {

namespace {

/// Text, but none of the texts that have readers of their own.
bool recognises(const std::string& path) {
  file::InputFile file(path);
  char bytes[4096];
  const std::size_t count = file.read(bytes, sizeof bytes);
  const std::string_view beginning(bytes, count);
  return looks_like_text(beginning) && !file::is_labview(beginning) && !file::is_universal(beginning);
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
