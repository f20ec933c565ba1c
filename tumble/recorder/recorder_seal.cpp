#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <span>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/confinement.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/pyramid/live_samples.hpp"
#include "tumble/recorder/live_store/file_blocks.hpp"
#include "tumble/recorder/live_store/read_recordings.hpp"
#include "tumble/recorder/live_store/visit.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace fs = std::filesystem;

namespace {

/// Where a recording goes: what was asked for, what the store says (from its folder), or the name of every run.
fs::path seal_target_of(const std::string& folder, const std::string& wanted, const StoreContent& content) {
  if (!wanted.empty()) return wanted;
  if (const auto fact = content.facts.find("target"); fact != content.facts.end())
    return file_named_in(folder, fact->second);
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

constexpr std::size_t sealed_at_once = std::size_t{1} << 17;  ///< samples of a channel: a chunk of the file

/// Hands out the recording of a slot, as often as it is asked for.
using BlockSource = std::function<void(const BlockSink& sink)>;

/// Equal but for the rounding of the unit that the file has: of 0 degC some digits are lost in kelvin.
bool same_sealed_values(const Channel& channel, std::span<const double> a, std::span<const double> b) {
  const double zero = std::abs(channel.unit.to_si(0.0));
  const auto same = [zero](double x, double y) {
    return (std::isnan(x) && std::isnan(y)) || std::abs(x - y) <= 1e-14 * (std::abs(x) + zero);
  };
  return std::ranges::equal(a, b, same);
}

/// A file beside the blocks that were written into it.
class Verification {
 public:
  explicit Verification(const std::string& path) : file_(path, sealed_at_once) {}

  void compare(const Recording& block) {
    if (same_ && read_.empty()) begin(block);
    for (std::size_t c = 0; same_ && c < block.channels.size(); ++c) compare(c, block.channels[c]);
  }
  /// Whether all was the same, and the file has no more.
  bool holds() {
    while (same_ && take()) {
    }
    return same_ && std::ranges::all_of(read_, [](const Waiting& waiting) { return waiting.rest().empty(); });
  }

 private:
  struct Waiting {
    std::vector<double> values;
    std::size_t from = 0;
    std::span<const double> rest() const { return std::span(values).subspan(from); }
  };

  void begin(const Recording& block) {
    read_.resize(block.channels.size());
    for (const Channel& channel : block.channels) names_.push_back(channel.name);
    same_ = take() && marks_ == block.marks.size();
  }

  /// One more block of the file.
  bool take() {
    const auto block = file_.next();
    if (!block) return false;
    marks_ = block->marks.size();
    same_ = same_ && block->channels.size() == names_.size();
    for (std::size_t c = 0; same_ && c < names_.size(); ++c) {
      const Channel* const channel = find_channel(*block, names_[c]);
      if (!channel) return same_ = false;
      Waiting& waiting = read_[c];
      waiting.values.erase(waiting.values.begin(), waiting.values.begin() + static_cast<std::ptrdiff_t>(waiting.from));
      waiting.from = 0;
      waiting.values.insert(waiting.values.end(), channel->values.begin(), channel->values.end());
    }
    return same_;
  }

  void compare(std::size_t c, const Channel& channel) {
    for (std::span<const double> wanted = channel.values; same_ && !wanted.empty();) {
      if (read_[c].rest().empty() && !take()) same_ = false;
      const std::size_t count = std::min(wanted.size(), read_[c].rest().size());
      same_ = same_ && same_sealed_values(channel, wanted.first(count), read_[c].rest().first(count));
      read_[c].from += count;
      wanted = wanted.subspan(count);
    }
  }

  live_store::FileBlocks file_;
  std::vector<std::string> names_;
  std::vector<Waiting> read_;  ///< of the file, by channel, and not compared yet
  std::size_t marks_ = 0;
  bool same_ = true;
};

/// What was written is read back: channels, samples and marks. Units may round the last digit of a sample.
void verify_sealed(const BlockSource& source, const std::string& path) {
  Verification verification(path);
  source([&](const Recording& block) {
    hand_out(block, sealed_at_once, [&](const Recording& part) { verification.compare(part); });
  });
  if (!verification.holds())
    throw Error(Error::Kind::bad_file, say("'{}' does not read back as it was written; the live store is kept", path));
}

/// The file under a name of its own, before it is read back.
std::vector<Finding> write_part(const BlockSource& source, const std::string& part, const fs::path& target,
                                Disk& disk) {
  std::vector<Finding> findings;
  try {
    disk.produce(part, [&] {
      const RecordingWriter writer = format_to_write("recording.h5").writer(part);
      source([&](const Recording& block) {
        writer.append(block);
        findings = block.findings;
      });
      writer.commit();
    });
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_file) throw;
    auto problems = error.problems;
    for (Problem& problem : problems)
      problem = within(say("'{}' was not written, and the live store is kept", target.string()), problem);
    throw Error(Error::Kind::bad_file, problems);
  }
  return findings;
}

/// Writes one file under its name, whole or not at all. Returns its SHA-256, and the findings of the recording.
SealedRecording write_sealed(const BlockSource& source, const fs::path& target, Disk& disk) {
  SealedRecording sealed;
  const std::string part = target.string() + ".part";
  sealed.findings = write_part(source, part, target, disk);
  disk.synchronise(part);
  sealed.sha256 = sha256_of_file(part);
  verify_sealed(source, part);
  disk.rename(part, target.string());
  disk.synchronise_folder(folder_of_file(target));
  sealed.path = target.string();
  if (sha256_of_file(sealed.path) != sealed.sha256)
    throw Error(Error::Kind::bad_file,
                say("'{}' has changed while it was sealed; the live store is kept", target.string()));
  return sealed;
}

}  // namespace

std::vector<SealedRecording> seal(const std::string& run, Disk& disk, const std::string& target,
                                  const Progress& progress) {
  const std::string path = live_store::path_of_store(run);
  live_store::StoreFile store = live_store::open_store(path, disk);
  try {
    live_store::StoreReading reading(store, path, progress);
    const fs::path wanted = seal_target_of(folder_of_file(path), target, reading.content());
    std::vector<SealedRecording> sealed;
    live_store::Batch batch;
    batch.last = store.state().last;
    batch.time = store.state().time;
    for (std::size_t i = 0; i < reading.slots().size(); ++i) {
      report(progress, 0.4 + 0.6 * static_cast<double>(i) / static_cast<double>(reading.slots().size()), "writing");
      const std::string& slot = reading.slots()[i];
      const fs::path file = with_slot(wanted, slot, reading.slots().size() > 1);
      sealed.push_back(
          write_sealed([&](const BlockSink& sink) { reading.stream(i, sealed_at_once, sink); }, file, disk));
      sealed.back().slot = slot;
      batch.facts[std::string(sealed_fact) + (slot.empty() ? "" : "." + slot)] = sealed.back().sha256;
    }
    store.write(batch);
    std::error_code ignored;  // the file that was sealed is looked at from now on
    fs::remove(fs::path(folder_of_file(path)) / live_samples_name, ignored);
    return sealed;
  } catch (const live_store::Refusal& refusal) {
    throw Error(Error::Kind::bad_file, say("'{}' cannot be sealed: {}", path, system_reason(refusal.text)));
  }
}

}  // namespace tumble
