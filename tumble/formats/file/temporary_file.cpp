#include "tumble/formats/file/temporary_file.hpp"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble::file {

namespace {

/// A name without folders, of characters that every file system has.
std::string plain_name(const std::string& name) {
  std::string plain = name.substr(name.find_last_of("/\\") + 1);
  for (char& c : plain)
    if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7f) c = '_';
  if (plain.size() > 100) plain.erase(0, plain.size() - 100);
  return plain.empty() || plain.front() == '.' ? "file" + plain : plain;
}

}  // namespace

TemporaryFile::TemporaryFile(const std::string& name, std::string from) : from_(std::move(from)) {
  std::error_code problem;
  std::string pattern = (std::filesystem::temp_directory_path(problem) / "tumble-XXXXXX").string();
  if (problem || mkdtemp(pattern.data()) == nullptr) refuse(problem ? problem.value() : errno);
  folder_ = pattern;
  path_ = folder_ / plain_name(name);
  file_ = std::fopen(path_.c_str(), "wbe");
  if (file_ == nullptr) {
    const int code = errno;
    std::filesystem::remove_all(folder_, problem);
    refuse(code);
  }
}

TemporaryFile::~TemporaryFile() {
  if (file_ != nullptr) static_cast<void>(std::fclose(file_));
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void TemporaryFile::refuse(int code) const {
  throw Error{Error::Kind::bad_file,
              "'" + from_ + "': it is unpacked into the folder for temporary files (TMPDIR), and that failed: " +
                  std::system_category().message(code)};
}

void TemporaryFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) refuse(errno);
}

void TemporaryFile::close() {
  std::FILE* const file = std::exchange(file_, nullptr);
  if (file != nullptr && std::fclose(file) != 0) refuse(errno);
}

}  // namespace tumble::file
