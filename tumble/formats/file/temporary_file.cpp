#include "tumble/formats/file/temporary_file.hpp"

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

Sentence failure_of(const std::string& from) {
  return say("'{}': it is unpacked into the folder for temporary files (TMPDIR), and that failed", from);
}

}  // namespace

TemporaryFile::TemporaryFile(const std::string& name, std::string from)
    : from_(std::move(from)), folder_(failure_of(from_)), path_(folder_.path() / plain_name(name)) {
  file_ = std::fopen(path_.c_str(), "wbe");
  if (file_ == nullptr) refuse(errno);
  unfinished_ = Unfinished(path_);
}

TemporaryFile::~TemporaryFile() {
  if (file_ != nullptr) static_cast<void>(std::fclose(file_));
}

void TemporaryFile::refuse(int code) const {
  throw Error{Error::Kind::bad_file, say("{}: {}", failure_of(from_), system_reason(code))};
}

void TemporaryFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) refuse(errno);
}

void TemporaryFile::close() {
  std::FILE* const file = std::exchange(file_, nullptr);
  if (file != nullptr && std::fclose(file) != 0) refuse(errno);
}

}  // namespace tumble::file
