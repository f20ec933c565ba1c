#include "tumble/formats/format.hpp"

#include <algorithm>

#include "tumble/formats/file/input_file.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

constexpr std::size_t block_samples = 65536;

const Format* by_extension(const std::string& path) {
  for (const Format* format : format_catalogue())
    for (const std::string& extension : format->extensions)
      if (path.size() > extension.size() &&
          std::equal(extension.rbegin(), extension.rend(), path.rbegin(),
                     [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); }))
        return format;
  return nullptr;
}

std::string extensions() {
  std::string text;
  for (const Format* format : format_catalogue())
    for (const std::string& extension : format->extensions) text += (text.empty() ? "" : ", ") + extension;
  return text;
}

/// MATLAB's own files say so in their first bytes, except those of version 4, where the name has to do.
bool is_matlab(const std::string& path) {
  std::string bytes(6, '\0');
  bytes.resize(file::InputFile(path).read(bytes.data(), bytes.size()));
  return bytes == "MATLAB" || path.ends_with(".mat");
}

const Format& format_for(const std::string& path) {
  if (const Format* format = by_extension(path)) return *format;
  throw Error{Error::Kind::bad_input,
              "'" + path + "': the name must say which format to write; known are " + extensions()};
}

}  // namespace

const Format& format_of(const std::string& path) {
  if (file::InputFile(path).size() == 0) throw Error{Error::Kind::bad_file, "'" + path + "' is empty"};
  for (const Format* format : format_catalogue())
    if (format->recognises(path)) return *format;
  if (is_matlab(path))
    throw Error{Error::Kind::bad_file,
                "'" + path +
                    "' is a MATLAB binary file, which is not read; write it from MATLAB as text, "
                    "writetable(array2table(data, 'VariableNames', names), 'data.csv'), or as HDF5, h5write"};
  if (const Format* format = by_extension(path)) return *format;
  throw Error{Error::Kind::bad_file, "'" + path +
                                         "' is not a recording that can be read: neither its content nor its "
                                         "name says which; known are " +
                                         extensions()};
}

Recording read_recording(const std::string& path, const ReadOptions& options, const Progress& progress) {
  return format_of(path).read(path, options, progress);
}

RecordingWriter recording_writer(const std::string& path) { return format_for(path).writer(path); }

void write_recording(const Recording& recording, const std::string& path) {
  const RecordingWriter writer = recording_writer(path);
  writer.append(recording);
  writer.commit();
}

void convert(const std::string& from, const std::string& to, const ReadOptions& options, const Progress& progress) {
  const Format& source = format_of(from);
  const RecordingWriter writer = recording_writer(to);
  source.stream(from, options, block_samples, writer.append, progress);
  writer.commit();
}

}  // namespace tumble
