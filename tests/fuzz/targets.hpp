#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tumble::fuzz {

/// What can be given hostile bytes: each format of the catalogue by its name; "declaration", a declaration of frames,
/// and "frame_stream", bytes for the shipped ones; "controller" and "controller_bytes", the same of controllers; "plan",
/// "result" and "station"; "route", a request to the workbench; "archive", the database of an archive.
std::vector<std::string> target_names();

/// Gives `bytes` to a target; `path` is a file to write them to.
/// Returned  empty, or what is wrong; a crash is for a sanitiser to see
std::string run_target(const std::string& name, std::string_view bytes, const std::string& path);

/// Bytes to begin with: small files of the repository at `root` that belong to the target, and others made here.
std::vector<std::string> seeds_of(const std::string& name, const std::string& root, const std::string& path);

}  // namespace tumble::fuzz
