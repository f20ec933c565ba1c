#include "tumble/formats/file/unread.hpp"

#include "tumble/formats/file/input_file.hpp"

namespace tumble::file {
namespace {

/// MATLAB's own files say so in their first bytes, except those of version 4, where the name has to do.
bool is_matlab(const std::string& path) {
  std::string bytes(6, '\0');
  bytes.resize(InputFile(path).read(bytes.data(), bytes.size()));
  return bytes == "MATLAB" || path.ends_with(".mat");
}

}  // namespace

Sentence advice_for_unread(const std::string& path) {
  if (is_matlab(path))
    return "a MATLAB binary file that is damaged or of an unknown version; write it from MATLAB as text, "
           "writetable(array2table(data, 'VariableNames', names), 'data.csv'), or as HDF5, h5write";
  return {};
}

Sentence advice_for_other_kind(const std::string& path) {
  if (path.ends_with(".toml"))
    return say("a plan or another declaration, and a recording is needed; the plan comes first: tumble identify {}",
               Name{path});
  std::string begin(512, '\0');
  begin.resize(InputFile(path).read(begin.data(), begin.size()));
  if (begin.starts_with('{') && begin.find("\"tumble\"") != begin.npos)
    return say("a result, and a recording is needed; to read the result: tumble report {}", Name{path});
  return {};
}

}  // namespace tumble::file
