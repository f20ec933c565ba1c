#include "tumble/formats/hdf5/handle.hpp"

namespace tumble::hdf5 {

namespace {

/// Every handle here has an owner. What the library would do at the exit of the program is to try once more to write
/// the files that a full disk kept it from closing, and to crash over that (1.10.8). It must be told before anything
/// else.
std::recursive_mutex& library() {
  static const bool no_farewell = H5dont_atexit() >= 0;
  static std::recursive_mutex mutex;
  (void)no_farewell;
  return mutex;
}

}  // namespace

Handle::~Handle() {
  if (close() || problem_ == nullptr || !problem_->empty()) return;
  *problem_ = last_reason().text();
}

Session::Session() : lock_(library()) {
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }

Sentence last_reason() {
  std::string reason;
  const auto take = [](unsigned, const H5E_error2_t* error, void* text) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
    return 1;  // the first is the innermost
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &reason);
  // Of a failed write the library tells time, file, buffer and counts; in the midst of it the system's reason.
  constexpr std::string_view mark = "error message = '";
  if (const auto begin = reason.find(mark); begin != std::string::npos)
    reason = reason.substr(begin + mark.size(), reason.find('\'', begin + mark.size()) - begin - mark.size());
  return reason.empty() ? "the HDF5 library gives no reason" : reason.c_str();
}

}  // namespace tumble::hdf5
