#include "tumble/formats/format.hpp"
#include "tumble/formats/frames/choose.hpp"
#include "tumble/formats/frames/read.hpp"

namespace tumble::frames {

namespace {

/// Whether shipped declarations explain its first bytes; which one is said when it is read.
bool recognises(const std::string& path) {
  for (const Match& match : matches_of(beginning_of(path)))
    if (match.explains) return true;
  return false;
}

}  // namespace

extern const Format frames{
    .name = "frames",
    .summary = "raw bytes of an instrument, by a declaration of its frames (tumble list instruments)",
    .extensions = {".frames", ".raw", ".sbp", ".mip"},
    .recognises = recognises,
    .read = tumble::frames::read,
    .memory = tumble::frames::memory,
    .stream = tumble::frames::stream,
    .asked_last = true};

}  // namespace tumble::frames
