// The part of ZIP that is used here: APPNOTE.TXT 6.3.10 of PKWARE, sections 4.3.7, 4.3.12, 4.3.14 to 4.3.16 and 4.5.3.
#include "tumble/formats/zip/archive.hpp"

#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/packed.hpp"
#include "tumble/units/error.hpp"

namespace tumble::zip {

namespace {

constexpr std::size_t end_size = 22, end64_size = 56, locator_size = 20, central_size = 46, local_size = 30;
constexpr std::size_t most_entries = 100'000;

[[noreturn]] void refuse(const std::string& path, const Sentence& reason) {
  throw Error{Error::Kind::bad_file, say("'{}': {}", path, reason)};
}

/// A little-endian number of `count` bytes.
std::uint64_t number_at(std::string_view bytes, std::size_t offset, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
  return value;
}

/// The archive as bytes at a place.
class Archive {
 public:
  explicit Archive(const std::string& path)
      : path_(path), size_(file::InputFile(path).size()), file_(path, std::ios::binary) {}

  std::uint64_t size() const { return size_; }
  std::string bytes(std::uint64_t offset, std::uint64_t count) {
    if (offset > size_ || count > size_ - offset)
      refuse(path_, "its directory points behind its end; the file was cut off or damaged");
    std::string bytes(count, '\0');
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    if (static_cast<std::uint64_t>(file_.gcount()) != count) refuse(path_, "it cannot be read to its end");
    return bytes;
  }

 private:
  std::string path_;
  std::uint64_t size_;
  std::ifstream file_;
};

struct Directory {
  std::uint64_t offset = 0, size = 0, entries = 0;
};

/// Where the record at the end begins: a comment of the length that it says follows, up to the end of the file. Such
/// bytes may stand in a comment too; where none fits, something was added behind the archive. npos: there is none.
std::size_t end_record_in(std::string_view tail) {
  const std::size_t last = tail.rfind("PK\x05\x06");
  for (std::size_t at = last; at != tail.npos; at = at == 0 ? tail.npos : tail.rfind("PK\x05\x06", at - 1))
    if (tail.size() - at >= end_size && at + end_size + number_at(tail, at + 20, 2) == tail.size()) return at;
  return last;
}

/// The end of the archive says where its directory is.
Directory directory_of(Archive& archive, const std::string& path) {
  const std::uint64_t tail_size = std::min<std::uint64_t>(archive.size(), end_size + 65535);
  const std::uint64_t tail_begin = archive.size() - tail_size;
  const std::string tail = archive.bytes(tail_begin, tail_size);
  const std::size_t at = end_record_in(tail);
  if (at == std::string::npos || tail.size() - at < end_size)
    refuse(path, "a zip archive without its directory; the file was cut off");
  Directory directory{number_at(tail, at + 16, 4), number_at(tail, at + 12, 4), number_at(tail, at + 10, 2)};
  const bool large = directory.offset == 0xFFFFFFFF || directory.size == 0xFFFFFFFF || directory.entries == 0xFFFF;
  if (!large || at < locator_size || std::string_view(tail).substr(at - locator_size, 4) != "PK\x06\x07")
    return directory;
  const std::string end64 = archive.bytes(number_at(tail, at - locator_size + 8, 8), end64_size);
  if (!end64.starts_with("PK\x06\x06")) refuse(path, "its directory is damaged");
  return {number_at(end64, 48, 8), number_at(end64, 40, 8), number_at(end64, 32, 8)};
}

/// Sizes that do not fit 32 bits stand in an extra field, in this order, those alone that are needed.
void take_large_sizes(Entry& entry, std::string_view extra) {
  while (extra.size() >= 4) {
    const std::uint64_t id = number_at(extra, 0, 2), size = number_at(extra, 2, 2);
    if (size > extra.size() - 4) return;
    std::string_view field = extra.substr(4, size);
    if (id == 1)
      for (std::uint64_t* const value : {&entry.size, &entry.packed, &entry.header})
        if (*value == 0xFFFFFFFF && field.size() >= 8) {
          *value = number_at(field, 0, 8);
          field.remove_prefix(8);
        }
    extra.remove_prefix(4 + size);
  }
}

/// Folders, and files that systems add.
bool of_the_system(std::string_view name) {
  const auto base = name.substr(name.find_last_of('/') + 1);
  return name.empty() || base.empty() || name.starts_with("__MACOSX/") || base.starts_with("._") ||
         base == ".DS_Store" || base == "Thumbs.db";
}

}  // namespace

bool is_archive(const std::string& path) {
  char bytes[4];
  const bool whole = file::InputFile(path).read(bytes, sizeof bytes) == sizeof bytes;
  const std::string_view beginning(bytes, sizeof bytes);
  return whole && (beginning == std::string_view("PK\x03\x04", 4) || beginning == std::string_view("PK\x05\x06", 4));
}

std::vector<Entry> entries_of(const std::string& path) {
  if (!is_archive(path)) refuse(path, "not a zip archive");
  Archive archive(path);
  const Directory directory = directory_of(archive, path);
  if (directory.entries > most_entries) refuse(path, "a zip archive of more than 100000 files");
  const std::string bytes = archive.bytes(directory.offset, directory.size);
  std::vector<Entry> entries;
  std::string_view text = bytes;
  for (std::uint64_t i = 0; i < directory.entries; ++i) {
    if (text.size() < central_size || !text.starts_with("PK\x01\x02")) refuse(path, "its directory is damaged");
    const std::uint64_t name = number_at(text, 28, 2), extra = number_at(text, 30, 2), comment = number_at(text, 32, 2);
    if (text.size() - central_size < name + extra + comment) refuse(path, "its directory is damaged");
    Entry entry;
    entry.encrypted = (number_at(text, 8, 2) & 1) != 0;
    entry.method = static_cast<std::uint16_t>(number_at(text, 10, 2));
    entry.checksum = static_cast<std::uint32_t>(number_at(text, 16, 4));
    entry.packed = number_at(text, 20, 4);
    entry.size = number_at(text, 24, 4);
    entry.header = number_at(text, 42, 4);
    entry.name = text.substr(central_size, name);
    take_large_sizes(entry, text.substr(central_size + name, extra));
    if (!of_the_system(entry.name)) entries.push_back(entry);
    text.remove_prefix(central_size + name + extra + comment);
  }
  return entries;
}

void unpack(const std::string& path, const Entry& entry, const file::ByteSink& sink) {
  const std::string from = path + ": " + entry.name;
  if (entry.encrypted) refuse(from, "it is encrypted; unpack it with its password first");
  if (entry.method != 0 && entry.method != 8)
    refuse(from, say("it is packed by method {}; stored and deflated files (methods 0 and 8) are read", entry.method));
  Archive archive(path);
  const std::string local = archive.bytes(entry.header, local_size);
  if (!local.starts_with("PK\x03\x04"))
    refuse(from, "its place in the archive holds something else; the archive is damaged");
  std::uint64_t offset = entry.header + local_size + number_at(local, 26, 2) + number_at(local, 28, 2);
  std::uint64_t size = 0;
  uLong checksum = crc32(0, nullptr, 0);
  const auto checked = [&](std::string_view bytes) {
    size += bytes.size();
    file::check_unpacked_size(size, entry.packed, from);
    checksum =
        crc32(checksum, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));  // NOLINT
    sink(bytes);
  };
  file::Inflater inflater(file::Inflater::Wrapping::raw, from);
  for (std::uint64_t left = entry.packed; left > 0;) {
    const std::uint64_t count = std::min<std::uint64_t>(left, 1 << 18);
    const std::string bytes = archive.bytes(offset, count);
    entry.method == 0 ? checked(bytes) : inflater.add(bytes, checked);
    offset += count;
    left -= count;
  }
  if (entry.method == 8) inflater.finish();
  if (size != entry.size || checksum != entry.checksum)
    refuse(from, "its bytes do not agree with their checksum; the archive is damaged");
}

Sentence listed(const std::vector<Entry>& entries) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(entries.size(), 10); ++i) {
    std::string name = entries[i].name;
    std::ranges::replace_if(
        name, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    text += (i > 0 ? ", '" : "'") + name + "'";
  }
  return entries.size() > 10 ? say("{} and {} more", Name{text}, entries.size() - 10) : say("{}", Name{text});
}

}  // namespace tumble::zip
