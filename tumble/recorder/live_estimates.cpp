#include "tumble/recorder/live_estimates.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "tumble/language/said.hpp"
#include "tumble/recorder/live_store/marks_of_journal.hpp"
#include "tumble/recorder/live_store/slot_reader.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace live {  // named, since Inner has them as members

constexpr std::size_t samples_in_block = std::size_t{1} << 14;
constexpr double rest = 4.0;  ///< [1] of the time that an estimate took, before the next one begins beside the run

/// Samples of all streams in the order in which they came.
struct SampleBlock {
  std::vector<std::uint32_t> streams;
  std::vector<std::uint64_t> sequences;
  std::vector<double> times, devices, values;  ///< devices: NaN where the sample has no time of the device

  std::size_t bytes() const {
    return streams.size() * (sizeof(std::uint32_t) + sizeof(std::uint64_t) + 2 * sizeof(double)) +
           values.size() * sizeof(double);
  }
};

/// All that was recorded up to one moment.
struct RecordedSoFar {
  StoreContent content;  ///< links and streams alone
  std::vector<std::shared_ptr<const SampleBlock>> blocks;
  live_store::JournalReader journal;
  double time = 0.0;  ///< [s]

  template <class Use>
  void each(Use use) const {
    StoreItem item;
    item.kind = StoreItem::Kind::sample;
    for (const auto& block : blocks) {
      std::size_t first = 0;
      for (std::size_t i = 0; i < block->streams.size(); ++i) {
        const std::size_t count = content.streams[block->streams[i]].channels.size();
        const double device = block->devices[i];
        item.source = block->streams[i];
        item.time = block->times[i];
        item.sample = {item.time, std::isnan(device) ? std::nullopt : std::optional(device), block->sequences[i],
                       std::span(block->values).subspan(first, count)};
        first += count;
        use(item);
      }
    }
  }
};

inline Recording recording_so_far(const RecordedSoFar& recorded, const std::string& slot) {
  live_store::SlotReader reader(recorded.content, slot);
  recorded.each([&](const StoreItem& item) { reader.look(item); });
  reader.settle();
  recorded.each([&](const StoreItem& item) { reader.take(item); });
  Recording recording;
  recording.instrument = reader.instrument();
  recording.channels = reader.channels();
  recording.marks = recorded.journal.marks_so_far(recorded.time);
  return recording;
}

struct GivenUp {};

inline double seconds_of_the_wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace live

using namespace live;

struct LiveEstimates::Inner {
  LiveEstimator estimator;
  LiveEstimatesOptions options;
  RecordedSoFar recorded;  ///< whole blocks
  SampleBlock block;       ///< the one that grows
  std::size_t bytes = 0;   ///< of whole blocks
  bool too_many = false;

  std::thread thread;
  std::atomic<bool> busy{false}, given_up{false};
  std::mutex mutex;  ///< of what stands below
  std::vector<Answer> answers;
  double ready_again = 0.0;  ///< [s] of the wall

  void close_block() {
    bytes += block.bytes();
    recorded.blocks.push_back(std::make_shared<const SampleBlock>(std::exchange(block, {})));
    too_many = too_many || (options.most_bytes > 0 && bytes > options.most_bytes);
    if (too_many) recorded.blocks.clear();
  }

  Answer answer_of(const RecordedSoFar& so_far, const std::string& slot) const {
    Answer answer{slot, so_far.time};
    try {
      const Progress progress = [this](double, std::string_view) {
        if (given_up) throw GivenUp{};
      };
      answer.estimate = std::make_shared<const Estimate>(estimator(recording_so_far(so_far, slot), progress));
    } catch (const GivenUp&) {
      answer.problem = "given up";
    } catch (const Error& error) {
      answer.problem = reason_of(error);
    } catch (const std::exception& problem) {
      answer.problem = said_by_library(problem.what());
    }
    return answer;
  }

  void work(const RecordedSoFar& so_far) {
    const double begin = seconds_of_the_wall();
    std::vector<Answer> all;
    for (const std::string& slot : live_store::slots_of(so_far.content))
      if (!given_up) all.push_back(answer_of(so_far, slot));
    const double end = seconds_of_the_wall();
    const std::lock_guard lock(mutex);
    for (Answer& answer : all) answers.push_back(std::move(answer));
    ready_again = end + rest * (end - begin);
  }
};

LiveEstimates::LiveEstimates(LiveEstimator estimator, LiveEstimatesOptions options)
    : inner_(std::make_unique<Inner>()) {
  inner_->estimator = std::move(estimator);
  inner_->options = options;
}

LiveEstimates::~LiveEstimates() {
  inner_->given_up = true;
  if (inner_->thread.joinable()) inner_->thread.join();
}

namespace live {

template <class One>
void put(std::vector<One>& all, std::size_t index, const One& one) {
  if (all.size() <= index) all.resize(index + 1);
  all[index] = one;
}

}  // namespace live

void LiveEstimates::link(std::size_t index, const StoreLink& link) { put(inner_->recorded.content.links, index, link); }

void LiveEstimates::stream(std::size_t index, const StoreStream& stream) {
  put(inner_->recorded.content.streams, index, stream);
}

void LiveEstimates::sample(std::size_t stream, const StoreSample& sample) {
  Inner& in = *inner_;
  if (in.too_many) return;
  in.block.streams.push_back(static_cast<std::uint32_t>(stream));
  in.block.sequences.push_back(sample.sequence);
  in.block.times.push_back(sample.time);
  in.block.devices.push_back(sample.device.value_or(std::nan("")));
  in.block.values.insert(in.block.values.end(), sample.values.begin(), sample.values.end());
  if (in.block.streams.size() == samples_in_block) in.close_block();
}

void LiveEstimates::journal(double time, const RunRow& row) { inner_->recorded.journal.add(time, row); }

void LiveEstimates::load(const std::string& run) {
  // The streams are described before their samples: a first look takes these, a second one the samples.
  const StoreContent content = visit_store(run, [](const StoreItem&) {});
  for (std::size_t i = 0; i < content.links.size(); ++i) link(i, content.links[i]);
  for (std::size_t i = 0; i < content.streams.size(); ++i) stream(i, content.streams[i]);
  visit_store(run, [&](const StoreItem& item) {
    if (item.journal) journal(item.time, *item.journal);
    if (item.kind == StoreItem::Kind::sample) {
      StoreSample one = item.sample;
      one.time = item.time;
      sample(item.source, one);
    }
  });
}

bool LiveEstimates::begin(double now) {
  Inner& in = *inner_;
  if (in.busy || in.too_many || (in.block.streams.empty() && in.recorded.blocks.empty())) return false;
  {
    const std::lock_guard lock(in.mutex);
    if (in.options.beside && seconds_of_the_wall() < in.ready_again) return false;
  }
  RecordedSoFar so_far = in.recorded;
  if (!in.block.streams.empty()) so_far.blocks.push_back(std::make_shared<const SampleBlock>(in.block));
  so_far.time = now;
  if (!in.options.beside) {
    in.work(so_far);
    return true;
  }
  if (in.thread.joinable()) in.thread.join();
  in.busy = true;
  in.thread = std::thread([&in, so_far = std::move(so_far)] {
    in.work(so_far);
    in.busy = false;
  });
  return true;
}

std::vector<LiveEstimates::Answer> LiveEstimates::finished() {
  const std::lock_guard lock(inner_->mutex);
  return std::exchange(inner_->answers, {});
}

LiveEstimator estimator_of(const Plan& plan) {
  return [plan](Recording so_far, const Progress& progress) {
    std::vector<Recording> recordings;
    recordings.push_back(std::move(so_far));
    return identify(gather(plan, {}, std::move(recordings), progress), progress);
  };
}

}  // namespace tumble
