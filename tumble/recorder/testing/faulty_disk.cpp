#include "tumble/recorder/testing/faulty_disk.hpp"

#include "tumble/formats/atomic_file.hpp"

namespace tumble::testing {

namespace {

Outcome outcome_of(DiskState& state, const DiskCall& call) {
  switch (call.kind) {
    case DiskCall::Kind::produce:
      return state.produce(call.path);
    case DiskCall::Kind::synchronise:
      return state.synchronise(call.path);
    case DiskCall::Kind::synchronise_folder:
      return state.synchronise_folder(call.path);
    case DiskCall::Kind::rename:
      return state.rename(call.path, call.to);
    case DiskCall::Kind::remove:
      break;
  }
  return state.remove(call.path);
}

DiskTap tap_on(DiskState& state, const DiskVfs& vfs) {
  return {.before = [&state](const DiskCall& call) { return outcome_of(state, call); },
          .produced =
              [&state](const std::string& path) {
                if (state.tracks()) state.produced(path, read_text_file(path));
              },
          .failed = [&state] { state.note_error(); },
          .has_failed = [&state] { return state.failed(); },
          .vfs = vfs.name()};
}

}  // namespace

FaultyDisk::FaultyDisk(const DiskFault& fault) : state_(fault), vfs_(state_), disk_(tap_on(state_, vfs_)) {}

}  // namespace tumble::testing
