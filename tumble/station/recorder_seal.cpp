#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/station/recorder/read_recordings.hpp"
#include "tumble/station/recorder/visit.hpp"
#include "tumble/station/recorder_read.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

/// Where a recording goes: what was asked for, what the store says (from its folder), or the name of every run.
fs::path seal_target_of(const std::string& folder, const std::string& wanted, const StoreContent& content) {
  if (!wanted.empty()) return wanted;
  if (const auto fact = content.facts.find("target"); fact != content.facts.end())
    return (fs::path(folder) / fact->second).lexically_normal();
  return fs::path(folder) / "recording.h5";
}

fs::path with_slot(const fs::path& target, const std::string& slot, bool several) {
  if (!several) return target;
  std::string safe = slot;
  for (char& letter : safe)
    if (letter == '/' || letter == '\0') letter = '_';
  return target.parent_path() / (target.stem().string() + "-" + safe + target.extension().string());
}

std::string folder_of_file(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path().string() : std::string(".");
}

constexpr std::size_t verified_at_once = std::size_t{1} << 18;  ///< samples of a channel

/// Whether a block goes on with the samples of a channel from `first` on. Equal but for the rounding of the unit that
/// the file has: of 0 degC some digits are lost in kelvin.
bool continues(const Channel& channel, std::size_t first, const std::vector<double>& block) {
  const double zero = std::abs(channel.unit.to_si(0.0));
  const auto same = [zero](double x, double y) {
    return (std::isnan(x) && std::isnan(y)) || std::abs(x - y) <= 1e-14 * (std::abs(x) + zero);
  };
  return block.size() <= channel.values.size() - first &&
         std::ranges::equal(block, std::span(channel.values).subspan(first, block.size()), same);
}

/// What was written is read back, block after block: channels, samples and marks. Units may round the last digit of a
/// sample.
void verify_sealed(const Recording& recording, const std::string& path) {
  std::vector<std::size_t> read(recording.channels.size());
  std::optional<std::size_t> marks;
  bool same = true;
  stream_recording(format_of(path), path, {}, verified_at_once, [&](const Recording& block) {
    if (!marks) marks = block.marks.size();
    same = same && block.channels.size() == recording.channels.size();
    for (const Channel& channel : block.channels) {
      const auto own = std::ranges::find(recording.channels, channel.name, &Channel::name);
      same = same && own != recording.channels.end();
      if (!same) return;
      std::size_t& count = read[static_cast<std::size_t>(own - recording.channels.begin())];
      same = continues(*own, count, channel.values);
      count += channel.values.size();
    }
  }, {});
  for (std::size_t c = 0; c < read.size(); ++c) same = same && read[c] == recording.channels[c].values.size();
  if (!same || marks != recording.marks.size())
    throw Error(Error::Kind::bad_file,
                fmt::format("'{}' does not read back as it was written; the live store is kept", path));
}

/// Writes one file under its name, whole or not at all. Returns its SHA-256.
std::string write_sealed(const Recording& recording, const fs::path& target, Disk& disk) {
  const std::string part = target.string() + ".part";
  disk.produce(part, [&] {
    const RecordingWriter writer = format_to_write("recording.h5").writer(part);
    writer.append(recording);
    writer.commit();
  });
  disk.synchronise(part);
  const std::string sha256 = sha256_of_file(part);
  verify_sealed(recording, part);
  disk.rename(part, target.string());
  disk.synchronise_folder(folder_of_file(target));
  if (sha256_of_file(target.string()) != sha256)
    throw Error(Error::Kind::bad_file,
                fmt::format("'{}' has changed while it was sealed; the live store is kept", target.string()));
  return sha256;
}

}  // namespace

std::vector<SealedRecording> seal(const std::string& run, Disk& disk, const std::string& target,
                                  const Progress& progress) {
  const std::string path = recorder::path_of_store(run);
  recorder::StoreFile store = recorder::open_store(path, disk);
  try {
    const auto recordings = recorder::read_recordings(store, path, progress);
    const fs::path wanted = seal_target_of(folder_of_file(path), target, recorder::describe(store));
    std::vector<SealedRecording> sealed;
    recorder::Batch batch;
    batch.last = store.state().last;
    batch.time = store.state().time;
    for (const auto& [slot, recording] : recordings) {
      report(progress, 0.6, "writing");
      const fs::path file = with_slot(wanted, slot, recordings.size() > 1);
      sealed.push_back({slot, file.string(), write_sealed(recording, file, disk), recording.findings});
      batch.facts["sealed" + (slot.empty() ? "" : "." + slot)] = sealed.back().sha256;
    }
    store.write(batch);
    return sealed;
  } catch (const recorder::Refusal& refusal) {
    throw Error(Error::Kind::bad_file, fmt::format("'{}' cannot be sealed: {}", path, refusal.text));
  }
}

}  // namespace tumble
