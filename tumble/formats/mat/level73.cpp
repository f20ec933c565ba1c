// Version 7.3: a HDF5 file behind 512 bytes of MATLAB. A variable is a dataset, a structure a group, and the order of
// the dimensions is reversed.

#include <algorithm>

#include "tumble/formats/file/input_file.hpp"
#include "tumble/formats/hdf5/values.hpp"
#include "tumble/formats/mat/array.hpp"
#include "tumble/formats/mat/numbers.hpp"
#include "tumble/units/error.hpp"

namespace tumble::mat {
namespace {

constexpr int deepest_group = 16;
constexpr hsize_t longest_characters = 65536;
constexpr std::size_t longest_path = 1024;
constexpr hssize_t most_followed = 10000;           ///< of all cells and arrays of structures of a file
constexpr hsize_t most_at_once = hsize_t{1} << 19;  ///< numbers of a piece

class Level73 {
 public:
  Level73(const std::string& path, Contents& contents)
      : path_(path), contents_(contents), size_(file::InputFile(path).size()) {
    file_ = hdf5::Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (!file_.valid())
      throw Error(Error::Kind::bad_file,
                  say("'{}' cannot be opened as a MATLAB file of version 7.3: {} (is it cut off or damaged?)", path,
                      hdf5::last_reason()));
  }

  void group(const std::string& at, const std::string& prefix, int depth) {
    if (depth > deepest_group) return contents_.leave_out(prefix);
    for (const auto& [name, type] : members(at)) {
      if (name.starts_with('#')) continue;
      const std::string inner = (at == "/" ? "" : at) + "/" + name, shown = prefix.empty() ? name : prefix + "." + name;
      if (type == H5O_TYPE_GROUP && is_sparse(inner))
        contents_.leave_out(shown);
      else if (type == H5O_TYPE_GROUP)
        group(inner, shown, depth + 1);
      else if (type == H5O_TYPE_DATASET)
        dataset(inner, shown, depth);
    }
  }

 private:
  using Members = std::vector<std::pair<std::string, H5O_type_t>>;

  Members members(const std::string& at) const {
    const hdf5::Handle group(H5Gopen2(file_, at.c_str(), H5P_DEFAULT), H5Gclose);
    if (!group.valid()) throw Error(Error::Kind::bad_file, say("'{}': {}: {}", path_, Name{at}, hdf5::last_reason()));
    Members found;
    const auto visit = [](hid_t where, const char* name, const H5L_info_t* link, void* list) -> herr_t {
      H5O_info_t object;
      if (link->type != H5L_TYPE_HARD) return 0;
      if (H5Oget_info_by_name1(where, name, &object, H5P_DEFAULT) < 0) return -1;
      static_cast<Members*>(list)->emplace_back(name, object.type);
      return 0;
    };
    if (H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &found) < 0)
      throw Error(Error::Kind::bad_file, say("'{}': {}: {}", path_, Name{at}, hdf5::last_reason()));
    return found;
  }

  bool is_sparse(const std::string& at) const {
    const hdf5::Handle group(H5Gopen2(file_, at.c_str(), H5P_DEFAULT), H5Gclose);
    return group.valid() && H5Aexists(group, "MATLAB_sparse") > 0;
  }

  void dataset(const std::string& at, const std::string& name, int depth) try {
    hdf5::Numbers numbers;
    numbers.dataset = hdf5::Handle(H5Dopen2(file_, at.c_str(), H5P_DEFAULT), H5Dclose);
    if (!numbers.dataset.valid()) hdf5::fail(hdf5::last_reason());
    if (hdf5::number_attribute(numbers.dataset, "MATLAB_empty").value_or(0.0) != 0.0) return;
    if (H5Aexists(numbers.dataset, "MATLAB_object_decode") > 0) return contents_.leave_out(name);
    const hdf5::Handle type(H5Dget_type(numbers.dataset), H5Tclose);
    numbers.space = hdf5::Handle(H5Dget_space(numbers.dataset), H5Sclose);
    numbers.rank = H5Sget_simple_extent_ndims(numbers.space);
    if (H5Tequal(type, H5T_STD_REF_OBJ) > 0) return elements(numbers, at, name, depth);
    const bool flat = numbers.rank == 1 || numbers.rank == 2;
    if (!hdf5::is_number(type) || !flat) return contents_.leave_out(name);
    std::vector<hsize_t> extent(static_cast<std::size_t>(numbers.rank));
    H5Sget_simple_extent_dims(numbers.space, extent.data(), nullptr);
    const hsize_t columns = numbers.rank == 2 ? extent[0] : 1, rows = extent.back();
    if (rows == 0 || columns == 0) return;
    if (!hdf5::plausible(rows, size_) || !hdf5::plausible(rows * columns, size_) || rows > hsize_t{1} << 48)
      hdf5::fail("it claims more numbers than a file of this size can hold");
    contents_.budget.take_numbers(rows, columns);
    numbers.axis = numbers.rank == 2 && columns > rows ? 0 : numbers.rank - 1;
    numbers.count = extent[static_cast<std::size_t>(numbers.axis)];
    hdf5::look_at_storage(numbers, file_, at, extent, size_);
    const bool characters = hdf5::text_attribute(numbers.dataset, "MATLAB_class").value_or("") == "char";
    if (characters && rows * columns > longest_characters) return contents_.leave_out(name);
    contents_.numbers += rows * columns;
    if (contents_.keep == Keep::sizes_only) return;
    Array array(name, std::min(rows, columns), contents_.spool);
    fill(numbers, array);
    if (characters && array.vectors.size() == 1)
      contents_.keep_text(name, text_of(array.vectors.front()->take()));
    else if (!characters)
      contents_.keep_array(std::move(array));
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_file) throw;
    throw Error(Error::Kind::bad_file, say("'{}': {}: {}", path_, Name{name}, reason_of(error)));
  }

  /// A cell array or a field of an array of structures: each element is an object elsewhere, named as in version 5.
  void elements(hdf5::Numbers& of, const std::string& at, const std::string& name, int depth) {
    const hssize_t count = H5Sget_simple_extent_npoints(of.space);
    if (depth > deepest_group || count < 0 || count > most_followed - followed_) return contents_.leave_out(name);
    followed_ += count;
    std::vector<hsize_t> extent(static_cast<std::size_t>(of.rank));
    H5Sget_simple_extent_dims(of.space, extent.data(), nullptr);
    hdf5::look_at_storage(of, file_, at, extent, size_);
    std::vector<hobj_ref_t> references(static_cast<std::size_t>(count));
    if (H5Dread(of.dataset, H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT, references.data()) < 0)
      hdf5::fail(hdf5::last_reason());
    const bool cell = hdf5::text_attribute(of.dataset, "MATLAB_class").value_or("") == "cell";
    const auto dot = name.rfind('.');
    for (std::size_t k = 0; k < references.size(); ++k) {
      const std::string index = "." + std::to_string(k + 1);
      const std::string shown = cell || dot == name.npos ? name + index
                                : references.size() == 1 ? name
                                                         : name.substr(0, dot) + index + name.substr(dot);
      element(of.dataset, references[k], shown, depth + 1);
    }
  }

  void element(hid_t from, const hobj_ref_t& reference, const std::string& shown, int depth) {
    H5O_type_t type = H5O_TYPE_UNKNOWN;
    std::string at(longest_path, '\0');
    const bool known = H5Rget_obj_type2(from, H5R_OBJECT, &reference, &type) >= 0;
    const ssize_t length = known ? H5Rget_name(from, H5R_OBJECT, &reference, at.data(), at.size()) : 0;
    if (length <= 0 || static_cast<std::size_t>(length) >= at.size()) return contents_.leave_out(shown);
    at.resize(static_cast<std::size_t>(length));
    if (type == H5O_TYPE_GROUP && !is_sparse(at))
      group(at, shown, depth);
    else if (type == H5O_TYPE_DATASET)
      dataset(at, shown, depth);
    else
      contents_.leave_out(shown);
  }

  /// Pieces along the longer side, with all of the shorter.
  static void fill(const hdf5::Numbers& numbers, Array& array) {
    const std::size_t vectors = array.vectors.size();
    const bool along_last = numbers.axis == numbers.rank - 1;
    const hsize_t step = std::max<hsize_t>(1, std::min(numbers.piece, most_at_once / vectors));
    std::vector<double> values;
    for (hsize_t first = 0; first < numbers.count; first += step) {
      const hsize_t now = std::min(step, numbers.count - first);
      std::vector<hsize_t> start(static_cast<std::size_t>(numbers.rank), 0), length(start.size(), vectors);
      start[static_cast<std::size_t>(numbers.axis)] = first;
      length[static_cast<std::size_t>(numbers.axis)] = now;
      values.resize(vectors * now);
      const hdf5::Handle memory(H5Screate_simple(numbers.rank, length.data(), nullptr), H5Sclose);
      if (H5Sselect_hyperslab(numbers.space, H5S_SELECT_SET, start.data(), nullptr, length.data(), nullptr) < 0 ||
          H5Dread(numbers.dataset, H5T_NATIVE_DOUBLE, memory, numbers.space, H5P_DEFAULT, values.data()) < 0)
        hdf5::fail(hdf5::last_reason());
      for (std::size_t v = 0; v < vectors; ++v)
        for (hsize_t k = 0; k < now; ++k) array.vectors[v]->add(values[along_last ? v * now + k : k * vectors + v]);
    }
  }

  const std::string& path_;
  Contents& contents_;
  std::size_t size_;
  hssize_t followed_ = 0;  ///< elements of cells and arrays of structures
  hdf5::Handle file_;
};

}  // namespace

Contents read_hdf5(const std::string& path, Keep keep) {
  const hdf5::Session session;
  Contents contents(path, keep);
  Level73 file(path, contents);
  std::string head(116, '\0');
  head.resize(file::InputFile(path).read(head.data(), head.size()));
  contents.head = head;
  file.group("/", "", 0);
  return contents;
}

}  // namespace tumble::mat
