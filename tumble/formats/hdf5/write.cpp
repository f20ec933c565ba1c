#include <algorithm>
#include <cmath>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/file/annotations.hpp"
#include "tumble/formats/file/plain_value.hpp"
#include "tumble/formats/hdf5/handle.hpp"
#include "tumble/formats/hdf5/read.hpp"
#include "tumble/math/interruption.hpp"
#include "tumble/units/error.hpp"

namespace tumble::hdf5 {

namespace {

constexpr hsize_t smallest_written_chunk = 1024;   // samples
constexpr hsize_t largest_written_chunk = 131072;  // 1 MB: the size of the library's cache

class Writer {
 public:
  explicit Writer(const std::string& path) : path_(path), target_(path) {
    if (!target_.replaces())
      throw Error{Error::Kind::bad_file, say("cannot write '{}': HDF5 needs a regular file", path)};
  }

  ~Writer() {
    const Session session;
    close();
  }

  void append(const Recording& block) {
    const Session session;
    if (!file_.valid()) begin(block);
    if (block.channels.size() != channels_.size())
      throw Error{Error::Kind::internal, say("'{}': blocks of one recording have different channels", path_)};
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      const Channel& channel = block.channels[i];
      extend(channels_[i].values, channel.values, channel.unit);
      if (channels_[i].stamps.dataset.valid()) extend(channels_[i].stamps, *channel.timeline.stamps, seconds_);
    }
  }

  void commit() {
    const Session session;
    if (!file_.valid()) throw Error{Error::Kind::bad_input, say("'{}': there is no channel to write", path_)};
    if (H5Fflush(file_, H5F_SCOPE_GLOBAL) < 0 || !close()) fail();
    if (!unclosed_->empty()) fail(Sentence(unclosed_->c_str()));
    target_.commit();
  }

 private:
  struct Dataset {
    Handle dataset;
    hsize_t count = 0;
  };
  struct Target {
    Dataset values;
    Dataset stamps;  ///< of the first channel of those that share them
  };

  [[noreturn]] void fail() const { fail(last_reason()); }
  [[noreturn]] void fail(const Sentence& reason) const {
    throw Error{Error::Kind::bad_file, say("cannot write '{}': {}", path_, reason)};
  }
  Handle checked(hid_t id, Handle::Close closer) const {
    if (id < 0) fail();
    return {id, closer, unclosed_.get()};
  }
  void check(herr_t status) const {
    if (status < 0) fail();
  }

  bool close() {
    bool good = true;
    for (Target& target : channels_) {
      const bool values = target.values.dataset.close(), stamps = target.stamps.dataset.close();
      good = good && values && stamps;
    }
    return file_.close() && good;
  }

  /// Object headers and groups of version 1.8 carry checksums, and everything reads them.
  void begin(const Recording& block) {
    if (block.channels.empty()) throw Error{Error::Kind::bad_input, say("'{}': there is no channel to write", path_)};
    const Handle access = checked(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18));
    check(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG));
    const Handle plist = creation(H5P_FILE_CREATE);
    file_ = checked(H5Fcreate(target_.temporary().c_str(), H5F_ACC_TRUNC, plist, access), H5Fclose);
    group("/channels");
    for (std::size_t i = 0; i < block.channels.size(); ++i) add(block, i);
    write_meta(block);
  }

  /// Without the time of day, which the library else writes into every object: the same data give the same bytes.
  Handle creation(hid_t kind) const {
    Handle plist = checked(H5Pcreate(kind), H5Pclose);
    check(H5Pset_obj_track_times(plist, false));
    return plist;
  }

  void group(const char* path) const {
    const Handle plist = creation(H5P_GROUP_CREATE);
    check(H5Pset_link_creation_order(plist, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
    checked(H5Gcreate2(file_, path, H5P_DEFAULT, plist, H5P_DEFAULT), H5Gclose);
  }

  static bool can_be_a_path(const std::string& name) {
    return !name.empty() && name.front() != '/' && name.back() != '/' && name.find("//") == std::string::npos &&
           name != "." && name.find('\0') == std::string::npos;
  }

  void add(const Recording& block, std::size_t index) {
    const Channel& channel = block.channels[index];
    if (!can_be_a_path(channel.name))
      throw Error{Error::Kind::bad_input, say("'{}': HDF5 cannot hold a channel named '{}'", path_, channel.name)};
    Target target;
    target.values = dataset("/channels/" + channel.name, channel.values.size());
    text(target.values.dataset, "unit", channel.unit.text());
    text(target.values.dataset, "quantity", std::string(name(channel.kind)));
    if (channel.timeline.uniform()) {
      number(target.values.dataset, "rate", channel.timeline.rate);
      number(target.values.dataset, "start", channel.timeline.start);
    } else {
      target.stamps = stamps(block, index);
    }
    channels_.push_back(std::move(target));
  }

  /// /time/<name>: a dataset, or one more link to that of an earlier channel with the same stamps.
  Dataset stamps(const Recording& block, std::size_t index) const {
    const Channel& channel = block.channels[index];
    if (H5Lexists(file_, "/time", H5P_DEFAULT) <= 0) group("/time");
    const std::string path = "/time/" + channel.name;
    for (std::size_t earlier = 0; earlier < index; ++earlier) {
      const Channel& other = block.channels[earlier];
      if (other.timeline.uniform() ||
          (other.timeline.stamps != channel.timeline.stamps && *other.timeline.stamps != *channel.timeline.stamps))
        continue;
      const Handle links = intermediate();
      check(H5Lcreate_hard(file_, ("/time/" + other.name).c_str(), file_, path.c_str(), links, H5P_DEFAULT));
      return {};
    }
    Dataset result = dataset(path, channel.values.size());
    text(result.dataset, "unit", "s");
    return result;
  }

  Handle intermediate() const {
    Handle links = checked(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    check(H5Pset_create_intermediate_group(links, 1));
    check(H5Pset_char_encoding(links, H5T_CSET_UTF8));
    return links;
  }

  Dataset dataset(const std::string& path, std::size_t first_block) const {
    const hsize_t none = 0, unlimited = H5S_UNLIMITED;
    const hsize_t chunk = std::clamp<hsize_t>(first_block, smallest_written_chunk, largest_written_chunk);
    const Handle space = checked(H5Screate_simple(1, &none, &unlimited), H5Sclose);
    const Handle plist = creation(H5P_DATASET_CREATE);
    check(H5Pset_chunk(plist, 1, &chunk));
    check(H5Pset_fill_time(plist, H5D_FILL_TIME_NEVER));
    const Handle links = intermediate();
    return {checked(H5Dcreate2(file_, path.c_str(), H5T_IEEE_F64LE, space, links, plist, H5P_DEFAULT), H5Dclose), 0};
  }

  Handle text_type(std::size_t size) const {
    Handle type = checked(H5Tcopy(H5T_C_S1), H5Tclose);
    check(H5Tset_size(type, std::max<std::size_t>(size, 1)));
    check(H5Tset_cset(type, H5T_CSET_UTF8));
    check(H5Tset_strpad(type, H5T_STR_NULLPAD));
    return type;
  }

  void text(hid_t object, const char* name, const std::string& value) const {
    const Handle type = text_type(value.size());
    const Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute = checked(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(attribute, type, value.c_str()));
  }

  void number(hid_t object, const char* name, double value) const {
    const Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute =
        checked(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value));
  }

  void write_meta(const Recording& block) const {
    const std::string json = file::all_annotations(block);
    const Handle type = text_type(json.size());
    const Handle plist = creation(H5P_DATASET_CREATE);
    const Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle dataset = checked(H5Dcreate2(file_, "/meta", type, space, H5P_DEFAULT, plist, H5P_DEFAULT), H5Dclose);
    check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, json.c_str()));
  }

  void extend(Dataset& target, const std::vector<double>& values, const Unit& unit) {
    for (std::size_t first = 0; first < values.size(); first += largest_written_chunk) {
      stop_if_asked();
      const hsize_t start = target.count;
      const hsize_t count = std::min<hsize_t>(largest_written_chunk, values.size() - first);
      scratch_.resize(count);
      for (hsize_t i = 0; i < count; ++i) {
        scratch_[i] = file::plain_value(values[first + i], unit);
        if (std::isinf(scratch_[i]))
          throw Error{Error::Kind::bad_data, say("'{}': a sample is infinite and cannot be written", path_)};
      }
      target.count += count;
      check(H5Dset_extent(target.dataset, &target.count));
      const Handle space = checked(H5Dget_space(target.dataset), H5Sclose);
      check(H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, nullptr, &count, nullptr));
      const Handle memory = checked(H5Screate_simple(1, &count, nullptr), H5Sclose);
      check(H5Dwrite(target.dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, scratch_.data()));
    }
  }

  std::string path_;
  AtomicFile target_;
  std::unique_ptr<std::string> unclosed_ = std::make_unique<std::string>();  ///< why a handle could not be closed
  Handle file_;
  std::vector<Target> channels_;
  std::vector<double> scratch_;
  Unit seconds_ = Unit::parse("s");
};

}  // namespace

RecordingWriter writer(const std::string& path) {
  const auto state = std::make_shared<Writer>(path);
  return {[state](const Recording& block) { state->append(block); }, [state] { state->commit(); }};
}

}  // namespace tumble::hdf5
