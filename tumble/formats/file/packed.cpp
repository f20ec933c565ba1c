#include "tumble/formats/file/packed.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/csv/cells.hpp"
#include "tumble/units/error.hpp"

namespace tumble::file {

namespace {

constexpr std::uintmax_t always_accepted = std::uintmax_t{64} << 20;  // [bytes]
constexpr std::uintmax_t greatest_ratio = 100;                        // text of samples has 3 to 20

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// "data.zip: imu.csv" in place of the copy's name.
std::string told_as(const PackedFile& packed) { return packed.outer + ": " + packed.name; }

/// The beginning of a command to copy.
std::string command_for(const PackedFile& packed) {
  return "tumble inspect " + csv::shell_word(packed.outer) +
         (packed.picked ? " --topic " + csv::shell_word(packed.name) : "");
}

/// Messages name the packed file instead of the copy.
template <class Action>
decltype(auto) renamed(const PackedFile& packed, Action action) {
  try {
    return action();
  } catch (const Error& error) {
    auto problems = error.problems;
    for (auto& problem : problems) {
      problem = with_values(problem, [&](const std::string& text) {
        return replaced(replaced(text, "tumble inspect " + csv::shell_word(packed.copy.path()), command_for(packed)),
                        packed.copy.path(), told_as(packed));
      });
    }
    throw Error(error.kind, problems);
  }
}

void rename_in(Recording& recording, const PackedFile& packed) {
  recording.origin.file = packed.outer;
  for (Finding& finding : recording.findings)
    if (finding.where == packed.copy.path()) finding.where = told_as(packed);
  recording.recognised.insert(recording.recognised.begin(), {"file inside", packed.name});
}

/// One unpacked copy, and of what.
struct Kept {
  std::mutex guard;
  std::string of;
  std::unique_ptr<TemporaryFile> copy;
};

Kept& kept() {
  static Kept one;
  return one;
}

/// Differs as soon as the file does.
std::string identity_of(const std::string& outer, const std::string& name) {
  struct stat status {};
  if (stat(outer.c_str(), &status) != 0) return "";
  return fmt::format("{} {} {} {} {} {}", status.st_dev, status.st_ino, status.st_size, status.st_mtim.tv_sec,
                     status.st_mtim.tv_nsec, name);
}

}  // namespace

std::unique_ptr<TemporaryFile> take_copy(const std::string& outer, const std::string& name) {
  const std::string identity = identity_of(outer, name);
  const std::lock_guard lock(kept().guard);
  if (identity.empty() || kept().of != identity) return nullptr;
  return std::move(kept().copy);
}

void leave_copy(const std::string& outer, const std::string& name, std::unique_ptr<TemporaryFile> copy) {
  std::string identity = identity_of(outer, name);
  const std::lock_guard lock(kept().guard);
  kept().of = std::move(identity);
  kept().copy = std::move(copy);
}

void check_unpacked_size(std::uintmax_t unpacked, std::uintmax_t packed, const std::string& from) {
  if (unpacked <= always_accepted || unpacked / greatest_ratio <= packed) return;
  throw Error{
      Error::Kind::bad_file,
      say("'{}': it unpacks to more than {} times its size, which samples do not; unpack it yourself if you trust it",
          from, Name{std::to_string(greatest_ratio)})};
}

const Format& format_of(const PackedFile& packed, const ReadOptions& options) {
  return renamed(packed, [&]() -> const Format& {
    const Format& format = tumble::format_of(packed.copy.path(), options);
    if (std::string_view(format.name) == "gzip" || std::string_view(format.name) == "zip")
      throw Error{Error::Kind::bad_file,
                  say("'{}' is a packed file in a packed file: unpack it first", packed.copy.path())};
    return format;
  });
}

Recording read(const PackedFile& packed, const ReadOptions& options, const Progress& progress) {
  return renamed(packed, [&] {
    Recording recording = file::format_of(packed, options).read(packed.copy.path(), options, progress);
    if (recording.origin.checksum) recording.origin.checksum();  // its thread reads the copy
    rename_in(recording, packed);
    recording.origin.checksum = sha256_in_background(packed.outer);
    return recording;
  });
}

std::uintmax_t memory(const PackedFile& packed, const ReadOptions& options) {
  return renamed(packed,
                 [&] { return recording_memory(file::format_of(packed, options), packed.copy.path(), options); });
}

void stream(const PackedFile& packed, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  const auto hand_on = [&](const Recording& block) {
    Recording copy = block;
    rename_in(copy, packed);
    sink(copy);
  };
  renamed(packed, [&] {
    stream_recording(file::format_of(packed, options), packed.copy.path(), options, samples, hand_on, progress);
    return 0;
  });
}

}  // namespace tumble::file
