#include "tumble/formats/hdf5/values.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "tumble/units/error.hpp"

namespace tumble::hdf5 {

namespace {

constexpr std::size_t longest_text = std::size_t{1} << 24;
constexpr hsize_t largest_readable_chunk = hsize_t{1} << 30;  // bytes

std::optional<std::string> text_of(hid_t type, hid_t space, const std::function<herr_t(hid_t, void*)>& read) {
  if (H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1) return std::nullopt;
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    if (read(type, &text) < 0 || text == nullptr) return std::nullopt;
    std::string result(text);
    H5free_memory(text);
    return result;
  }
  const std::size_t size = H5Tget_size(type);
  if (size == 0 || size > longest_text) return std::nullopt;
  std::string text(size, '\0');
  if (read(type, text.data()) < 0) return std::nullopt;
  text.resize(std::min(text.find('\0'), text.size()));
  while (H5Tget_strpad(type) == H5T_STR_SPACEPAD && text.ends_with(' ')) text.pop_back();
  return text;
}

Handle attribute_named(hid_t object, const char* name) {
  return H5Aexists(object, name) > 0 ? Handle(H5Aopen(object, name, H5P_DEFAULT), H5Aclose) : Handle();
}

}  // namespace

void fail(const Sentence& reason) { throw Error{Error::Kind::bad_file, std::move(reason)}; }

bool is_number(hid_t type) {
  constexpr std::size_t widest = 16;  // bytes; a damaged type may claim gigabytes for each
  const auto kind = H5Tget_class(type);
  return (kind == H5T_INTEGER || kind == H5T_FLOAT) && H5Tget_size(type) <= widest;
}

bool plausible(hsize_t count, std::size_t file_size) { return count / 1100 <= file_size; }

bool is_in_other_files(hid_t plist) { return H5Pget_layout(plist) == H5D_VIRTUAL || H5Pget_external_count(plist) > 0; }

void look_at_storage(Numbers& numbers, hid_t file, const std::string& path, const std::vector<hsize_t>& extent,
                     std::size_t file_size) {
  const Handle plist(H5Dget_create_plist(numbers.dataset), H5Pclose);
  if (!plist.valid()) fail(last_reason());
  if (is_in_other_files(plist)) fail("its samples are in another file");
  if (H5Pget_layout(plist) != H5D_CHUNKED) return;
  std::vector<hsize_t> chunk(extent.size());
  if (H5Pget_chunk(plist, numbers.rank, chunk.data()) < 0) fail(last_reason());
  hsize_t bytes = 8;
  for (const hsize_t length : chunk) {
    bytes *= length;
    if (bytes == 0 || bytes > largest_readable_chunk) fail("its chunks are larger than 1 GB");
  }
  if (!plausible(bytes / 8, file_size)) fail("its chunks are larger than a file of this size can hold");
  const hsize_t along = chunk[numbers.axis];
  numbers.piece = std::max(along, numbers.piece / along * along);
  if (bytes <= hsize_t{1} << 20) return;
  const Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access, 521, 2 * bytes, 1.0);
  numbers.dataset = Handle(H5Dopen2(file, path.c_str(), access), H5Dclose);
  if (!numbers.dataset.valid()) fail(last_reason());
}

bool exists(hid_t file, const std::string& path) {
  for (auto end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (H5Lexists(file, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

void require_of_file(hid_t file, hid_t object) {
  H5O_info_t of_file, of_object;
  if (H5Oget_info1(file, &of_file) < 0 || H5Oget_info1(object, &of_object) < 0) fail(last_reason());
  if (of_file.fileno != of_object.fileno)
    fail("a link leads to another file, whose checksum no result would state; copy the data into this file");
}

Numbers open_numbers(hid_t file, const std::string& path, std::size_t file_size) {
  Numbers numbers;
  numbers.dataset = Handle(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!numbers.dataset.valid()) fail(last_reason());
  require_of_file(file, numbers.dataset);
  const Handle type(H5Dget_type(numbers.dataset), H5Tclose);
  if (!is_number(type)) fail("it does not hold numbers");
  numbers.space = Handle(H5Dget_space(numbers.dataset), H5Sclose);
  numbers.rank = H5Sget_simple_extent_ndims(numbers.space);
  if (numbers.rank < 0) fail(last_reason());
  std::vector<hsize_t> extent(static_cast<std::size_t>(numbers.rank));
  if (numbers.rank > 0) H5Sget_simple_extent_dims(numbers.space, extent.data(), nullptr);
  const auto longer = std::count_if(extent.begin(), extent.end(), [](hsize_t length) { return length != 1; });
  if (longer > 1 || numbers.rank == 0) {
    std::string shape;
    for (const hsize_t length : extent) shape += (shape.empty() ? "" : " x ") + std::to_string(length);
    fail(say("it is {}, and one row of samples for each channel is expected",
             shape.empty() ? Sentence("one number") : say("{}", Name{shape})));
  }
  const auto longest = std::find_if(extent.begin(), extent.end(), [](hsize_t length) { return length != 1; });
  numbers.axis = longest == extent.end() ? 0 : static_cast<int>(longest - extent.begin());
  numbers.count = extent[numbers.axis];
  if (numbers.count == 0) fail("it has no samples");
  if (!plausible(numbers.count, file_size))
    fail(say("it claims {} samples, more than a file of this size can hold", numbers.count));
  look_at_storage(numbers, file, path, extent, file_size);
  const Handle plist(H5Dget_create_plist(numbers.dataset), H5Pclose);
  numbers.raw = raw_samples(file, numbers.dataset, plist, numbers.rank, numbers.count, file_size);
  return numbers;
}

namespace {

void read_by_library(const Numbers& numbers, hsize_t first, hsize_t count, double* to) {
  std::vector<hsize_t> start(numbers.rank, 0), length(numbers.rank, 1);
  while (count > 0) {
    const hsize_t now = std::min(count, numbers.piece - first % numbers.piece);
    start[numbers.axis] = first;
    length[numbers.axis] = now;
    const Handle memory(H5Screate_simple(1, &now, nullptr), H5Sclose);
    if (H5Sselect_hyperslab(numbers.space, H5S_SELECT_SET, start.data(), nullptr, length.data(), nullptr) < 0 ||
        H5Dread(numbers.dataset, H5T_NATIVE_DOUBLE, memory, numbers.space, H5P_DEFAULT, to) < 0)
      fail(last_reason());
    first += now;
    count -= now;
    to += now;
  }
}

/// In place, value * factor + offset [SI]. Whether no value is infinite.
bool to_si(double* values, std::size_t count, double factor, double offset) {
  using Lanes = double __attribute__((vector_size(16)));
  constexpr std::size_t width = sizeof(Lanes) / sizeof(double), rows = 4;
  const auto size_of = [](double value) { return std::abs(value); };
  Lanes highest[rows] = {}, lowest[rows] = {};
  std::size_t i = 0;
  for (; i + rows * width <= count; i += rows * width)
    for (std::size_t k = 0; k < rows; ++k) {
      Lanes value;
      std::memcpy(&value, values + i + k * width, sizeof value);
      highest[k] = value > highest[k] ? value : highest[k];  // of NaN neither is true
      lowest[k] = value < lowest[k] ? value : lowest[k];
      value = value * factor + offset;
      std::memcpy(values + i + k * width, &value, sizeof value);
    }
  double largest = 0.0;
  for (; i < count; ++i) {
    largest = size_of(values[i]) > largest ? size_of(values[i]) : largest;
    values[i] = values[i] * factor + offset;
  }
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t lane = 0; lane < width; ++lane) largest = std::max({largest, highest[k][lane], -lowest[k][lane]});
  return !std::isinf(largest);
}

}  // namespace

void append(const Numbers& numbers, hsize_t first, hsize_t count, double factor, double offset,
            std::vector<double>& values) {
  constexpr hsize_t in_the_cache = 1 << 15;
  const bool together = numbers.raw && numbers.raw->deflated;  // chunks that are unpacked side by side
  const hsize_t piece = together ? std::max<hsize_t>(first + count, 1) : numbers.raw ? in_the_cache : numbers.piece;
  const std::size_t before = values.size();
  values.resize(before + count);
  for (hsize_t done = 0; done < count;) {
    const hsize_t now = std::min(count - done, piece - (first + done) % piece);
    double* const to = values.data() + before + done;
    if (!numbers.raw || !read_raw(*numbers.raw, numbers.dataset, first + done, now, to))
      read_by_library(numbers, first + done, now, to);
    if (!to_si(to, now, factor, offset)) fail("it holds an infinite sample; a missing one is NaN");
    done += now;
  }
}

std::optional<std::string> text_attribute(hid_t object, const char* name) {
  const Handle attribute = attribute_named(object, name);
  if (!attribute.valid()) return std::nullopt;
  const Handle type(H5Aget_type(attribute), H5Tclose);
  const Handle space(H5Aget_space(attribute), H5Sclose);
  return text_of(type, space, [&](hid_t memory, void* to) { return H5Aread(attribute, memory, to); });
}

std::optional<double> number_attribute(hid_t object, const char* name) {
  const Handle attribute = attribute_named(object, name);
  if (!attribute.valid()) return std::nullopt;
  const Handle type(H5Aget_type(attribute), H5Tclose);
  const Handle space(H5Aget_space(attribute), H5Sclose);
  double value = 0.0;
  if (!is_number(type) || H5Sget_simple_extent_npoints(space) != 1 || H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0)
    return std::nullopt;
  return value;
}

std::optional<std::string> text_dataset(hid_t file, const char* path) {
  if (!exists(file, path)) return std::nullopt;
  const Handle dataset(H5Dopen2(file, path, H5P_DEFAULT), H5Dclose);
  if (!dataset.valid()) return std::nullopt;
  require_of_file(file, dataset);
  const Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  if (!plist.valid()) fail(last_reason());
  if (is_in_other_files(plist)) fail("its text is in another file");
  const Handle type(H5Dget_type(dataset), H5Tclose);
  const Handle space(H5Dget_space(dataset), H5Sclose);
  return text_of(type, space,
                 [&](hid_t memory, void* to) { return H5Dread(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, to); });
}

}  // namespace tumble::hdf5
