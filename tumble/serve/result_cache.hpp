#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "tumble/core/estimate.hpp"

namespace tumble {

/// Facts about a result that a list shows.
struct ResultSummary {
  std::string method, title, model, serial;
  std::string date;  ///< "2026-11-20" of the test, by its recordings; empty: they do not say it
  std::size_t parameters = 0, passed = 0, failed = 0, undecided = 0, errors = 0;
};

/// Results of a folder, each read once as long as its file stays the same.
class ResultCache {
 public:
  /// Nothing where the file is not a result, or a damaged one.
  std::optional<ResultSummary> summary(const std::string& path);
  /// Throws Error::bad_file.
  std::shared_ptr<const Estimate> read(const std::string& path);

 private:
  struct Entry {
    std::string path, version;  ///< version: changes with the file
    std::shared_ptr<const Estimate> estimate;
  };
  struct Listed {
    std::string version;
    std::optional<ResultSummary> summary;
  };
  static constexpr std::size_t most_read = 128;

  std::shared_ptr<const Estimate> find(const std::string& path, const std::string& version);

  std::mutex mutex_;
  std::list<Entry> read_;  ///< the latest first
  std::map<std::string, Listed> listed_;
};

}  // namespace tumble
