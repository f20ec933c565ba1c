#include "tumble/serve/result_cache.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tumble/exchange/test_days.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::uintmax_t largest_result = 64'000'000;  ///< [bytes]

/// Changes with the file; empty where there is none.
std::string version_of(const std::string& path) {
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(path, failed);
  if (failed) return {};
  const auto time = std::filesystem::last_write_time(path, failed);
  return failed ? "" : fmt::format("{} {}", bytes, time.time_since_epoch().count());
}

/// Every result begins with the version of its program: other JSON is not read whole.
bool looks_like_result(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string begin(64, '\0');
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(stream.gcount()));
  return begin.starts_with('{') && begin.find("\"tumble\"") != std::string::npos;
}

ResultSummary summary_of(const Estimate& estimate) {
  ResultSummary summary{estimate.method, estimate.title, estimate.instrument_model, estimate.instrument_serial, {}};
  if (const auto days = test_days(estimate))
    summary.date = fmt::format("{:04}-{:02}-{:02}", static_cast<int>(days->ended.year()),
                               static_cast<unsigned>(days->ended.month()), static_cast<unsigned>(days->ended.day()));
  summary.parameters = estimate.parameters.size();
  for (const auto& verdict : estimate.verdicts) {
    summary.passed += verdict.outcome == Verdict::Outcome::pass;
    summary.failed += verdict.outcome == Verdict::Outcome::fail;
    summary.undecided += verdict.outcome == Verdict::Outcome::undecided;
  }
  summary.errors =
      static_cast<std::size_t>(std::ranges::count(estimate.findings, Finding::Severity::error, &Finding::severity));
  return summary;
}

}  // namespace

std::optional<ResultSummary> ResultCache::summary(const std::string& path) {
  const auto version = version_of(path);
  {
    const std::scoped_lock lock(mutex_);
    const auto known = listed_.find(path);
    if (known != listed_.end() && known->second.version == version) return known->second.summary;
  }
  std::optional<ResultSummary> summary;
  if (!version.empty() && looks_like_result(path)) try {
      summary = summary_of(*read(path));
    } catch (const Error&) {
      summary = std::nullopt;
    }
  const std::scoped_lock lock(mutex_);
  listed_[path] = {version, summary};
  return summary;
}

std::shared_ptr<const Estimate> ResultCache::find(const std::string& path, const std::string& version) {
  const std::scoped_lock lock(mutex_);
  const auto known =
      std::ranges::find_if(read_, [&](const Entry& entry) { return entry.path == path && entry.version == version; });
  if (known == read_.end()) return nullptr;
  read_.splice(read_.begin(), read_, known);
  return read_.front().estimate;
}

std::shared_ptr<const Estimate> ResultCache::read(const std::string& path) {
  const auto version = version_of(path);
  if (auto known = find(path, version)) return known;
  const auto name = std::filesystem::path(path).filename().string();
  std::error_code failed;
  if (const auto bytes = std::filesystem::file_size(path, failed); !failed && bytes > largest_result)
    throw Error{Error::Kind::bad_file, say("{}: {} bytes are more than a result has", Name{name}, bytes)};
  auto estimate = std::make_shared<const Estimate>(estimate_from_json(read_text_file(path), name));
  const std::scoped_lock lock(mutex_);
  std::erase_if(read_, [&](const Entry& entry) { return entry.path == path; });
  read_.push_front({path, version, estimate});
  if (read_.size() > most_read) read_.pop_back();
  return estimate;
}

}  // namespace tumble
