// A read-only format of one's own: the file of a logger that writes the 8 bytes "MYLOGGER", the sampling rate [Hz], and
// then the rate of a gyro [deg/h] sample after sample, all as little-endian doubles.

#include <cmath>
#include <cstring>
#include <vector>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

namespace tumble::formats::my_format {
namespace {

constexpr std::string_view signature = "MYLOGGER";

bool recognises(const std::string& path) {
  char bytes[signature.size()];
  const std::size_t count = file::InputFile(path).read(bytes, sizeof bytes);
  return std::string_view(bytes, count) == signature;
}

/// All numbers after the signature. A file ends after a whole number, or it was cut off.
std::vector<double> numbers_of(const std::string& path) {
  file::InputFile file(path);
  std::string bytes(file.size(), '\0');
  std::size_t size = 0;
  while (const std::size_t count = file.read(bytes.data() + size, bytes.size() - size)) size += count;
  if (size < signature.size() + sizeof(double) || (size - signature.size()) % sizeof(double) != 0)
    throw Error(Error::Kind::bad_file,
                say("'{}': {} bytes; the signature of 8 bytes and 8 bytes for each number were expected", path, size));
  std::vector<double> numbers((size - signature.size()) / sizeof(double));
  std::memcpy(numbers.data(), bytes.data() + signature.size(), numbers.size() * sizeof(double));
  return numbers;
}

Recording read(const std::string& path, const ReadOptions&, const Progress&) {
  std::vector<double> numbers = numbers_of(path);
  const double rate = numbers.front();
  if (!(rate > 0.0 && std::isfinite(rate)))
    throw Error(Error::Kind::bad_file, say("'{}': the sampling rate at byte 8 must be above 0 Hz", path));
  Channel gyro{"gyro", QuantityKind::angular_rate, Unit::parse("deg/h"), {0.0, rate, nullptr}, {}};
  gyro.values.assign(numbers.begin() + 1, numbers.end());
  for (double& value : gyro.values) value = gyro.unit.to_si(value);
  Recording recording;
  recording.channels.push_back(std::move(gyro));
  recording.origin = {path, sha256_in_background(path)};
  return recording;
}

}  // namespace

extern const Format my_format{.name = "my_format",
                              .summary = "binary file of a logger: signature, sampling rate, samples",
                              .extensions = {".mylog"},
                              .recognises = recognises,
                              .read = read};

}  // namespace tumble::formats::my_format
