// A recording of any format, packed by gzip.

#include <memory>
#include <string_view>
#include <utility>

#include "tumble/formats/file/inflate.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/file/packed.hpp"
#include "tumble/units/error.hpp"

namespace tumble::gzip {

namespace {

bool recognises(const std::string& path) { return file::begins_with(path, "\x1f\x8b\x08"); }

/// "imu.csv" of "folder/imu.csv.gz".
std::string inner_name(const std::string& path) {
  std::string name = path.substr(path.find_last_of('/') + 1);
  return name.ends_with(".gz") ? name.substr(0, name.size() - 3) : name + ".unpacked";
}

bool is_tar(std::string_view beginning) { return beginning.size() > 262 && beginning.substr(257, 5) == "ustar"; }

/// Unpacks into a temporary file, unless that was done before.
std::unique_ptr<file::TemporaryFile> unpacked(const std::string& path) {
  if (auto copy = file::take_copy(path, inner_name(path))) return copy;
  if (!recognises(path)) throw Error{Error::Kind::bad_file, say("'{}' is not packed by gzip", path)};
  file::InputFile packed(path);
  auto copy = std::make_unique<file::TemporaryFile>(inner_name(path), path);
  file::Inflater inflater(file::Inflater::Wrapping::gzip, path);
  std::uintmax_t size = 0;
  const auto sink = [&](std::string_view bytes) {
    if (size == 0 && is_tar(bytes))
      throw Error{Error::Kind::bad_file,
                  say("'{}' is a tar archive: unpack it (tar xf), and name the file to read", path)};
    size += bytes.size();
    file::check_unpacked_size(size, packed.size(), path);
    copy->write(bytes);
  };
  std::string buffer(std::size_t{1} << 18, '\0');
  while (const std::size_t count = packed.read(buffer.data(), buffer.size()))
    inflater.add({buffer.data(), count}, sink);
  inflater.finish();
  copy->close();
  return copy;
}

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  const auto copy = unpacked(path);
  return file::read({*copy, path, inner_name(path)}, options, progress);
}

std::uintmax_t memory(const std::string& path, const ReadOptions& options) {
  auto copy = unpacked(path);
  const auto bytes = file::memory({*copy, path, inner_name(path)}, options);
  file::leave_copy(path, inner_name(path), std::move(copy));
  return bytes;
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  auto copy = unpacked(path);
  file::stream({*copy, path, inner_name(path)}, options, samples, sink, progress);
  file::leave_copy(path, inner_name(path), std::move(copy));
}

}  // namespace

extern const Format gzip{.name = "gzip",
                         .summary = "one file of any other format, packed by gzip",
                         .extensions = {".gz"},
                         .recognises = recognises,
                         .read = tumble::gzip::read,
                         .memory = memory,
                         .stream = stream};

}  // namespace tumble::gzip
