#pragma once

#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/pyramid/live_recording.hpp"
#include "tumble/pyramid/pyramid.hpp"
#include "tumble/serve/jobs.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// Builds what a workbench shows of a recording and keeps it in `cache`: `<sha256>.pyr`, and what `inspect` makes of
/// it as JSON. Nothing is done where it is there already. `inspect` gives the JSON.
/// Throws Error::bad_file, and as the readers do.
void prepare_recording(
    const std::string& recording, const Sets& sets, const std::filesystem::path& cache,
    const std::function<std::string(const std::string&, const ReadOptions&, const Progress&)>& inspect,
    const Progress& progress);

/// A prepared recording.
struct PreparedRecording {
  std::shared_ptr<const Pyramid> pyramid;
  std::string checksum;    ///< SHA-256 of the file; empty for a folder
  std::string tag;         ///< changes with the file and with how it is read
  std::string inspection;  ///< JSON of `inspect`; empty: not there yet
  /// State of a recording that is being made, or that was made and has not been sealed.
  struct Live {
    bool going_on = false, behind = false;
    std::string target;  ///< file that it becomes, from its folder
  };
  std::optional<Live> live;
};

/// How far a recording is.
struct RecordingState {
  std::shared_ptr<const PreparedRecording> prepared;  ///< null: not yet
  std::string job;                                    ///< that prepares it; empty: none
  Problems problems;                                  ///< why it cannot be read
};

/// Whether it is the file of a recording that is being made.
bool is_live(const std::filesystem::path& recording);

/// Prepared recordings, open as long as somebody looks at them.
class RecordingCache {
 public:
  RecordingCache(std::filesystem::path cache, Jobs& jobs) : cache_(std::move(cache)), jobs_(jobs) {}

  /// The prepared recording. Where it is not prepared and `start`, a job of `owner` begins to prepare it. For each
  /// recording the latest few ways to read it are kept. Throws Error::bad_file, bad_input.
  RecordingState find(const std::string& recording, const Sets& sets, bool start, const std::string& owner);

 private:
  struct Entry {
    std::string key;
    std::shared_ptr<const PreparedRecording> prepared;
  };
  static constexpr std::size_t most_open = 1000, most_live = 20, most_ways = 8;

  RecordingState live(const std::string& path);
  void remember_way(const std::string& recording, const std::string& key);
  std::shared_ptr<const PreparedRecording> open(const std::string& recording, const Sets& sets, const std::string& key);

  std::filesystem::path cache_;
  Jobs& jobs_;
  std::mutex mutex_;
  std::list<Entry> open_;                   ///< the latest first
  std::map<std::string, std::string> job_;  ///< by key
  std::map<std::string, std::list<std::string>>
      ways_;  ///< keys by recording that says how it is read, the latest first
  std::list<std::pair<std::string, std::shared_ptr<LiveRecording>>>
      live_;  ///< by file and its number, the latest first
};

}  // namespace tumble
