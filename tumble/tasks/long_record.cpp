#include "tumble/tasks/long_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/instant.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/state.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/streamed.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

Streamed stream_of(const Plan& plan, const std::string& file, const Progress& progress) {
  Plan alone = plan;
  alone.recordings.clear();
  auto streamed = open_stream(alone, {file}, 0, progress);
  if (!streamed)
    throw Error(Error::Kind::bad_data, say("{}: holds no samples, or cannot be read block after block", Name{file}));
  return std::move(*streamed);
}

/// How many samples are missing between two files [samples]; nothing where the clocks do not say it.
struct Step {
  double lost = 0.0, tolerance = 0.0;
};

enum class Clock { dates, stamps, none };

Step step_between(const RecordPiece& before, const RecordPiece& next, std::size_t channel, Clock clock) {
  const ChannelExtent &a = before.channels[channel], &b = next.channels[channel];
  const double length = a.end - a.begin;
  if (clock == Clock::dates) {
    const double seconds = 1e-9 * static_cast<double>(next.clock_start - before.clock_start) - length;
    return {seconds * a.rate - 1.0, (1.0 + 2e-4 * length) * a.rate};
  }
  return {(b.begin - a.end) * a.rate - 1.0, 1.5};
}

Clock clock_of(const std::vector<RecordPiece>& pieces) {
  if (std::ranges::all_of(pieces, [](const RecordPiece& one) { return one.clock_start != 0; })) return Clock::dates;
  double longest = 0.0, farthest = 0.0;
  for (const RecordPiece& piece : pieces) {
    const ChannelExtent &first = pieces.front().channels.front(), &here = piece.channels.front();
    longest = std::max(longest, here.end - here.begin);
    farthest = std::max(farthest, std::abs(here.begin - first.begin));
  }
  return farthest <= 0.01 * longest ? Clock::none : Clock::stamps;
}

/// What of a file does not fit to the first.
Problems misfits(const RecordPiece& piece, const RecordPiece& first) {
  if (piece.channels.size() != first.channels.size())
    return {say("{}: has {} channels, and {} has {}: all files of a record must have the same", Name{piece.file},
                piece.channels.size(), Name{first.file}, first.channels.size())};
  Problems problems;
  for (std::size_t k = 0; k < piece.channels.size(); ++k) {
    const ChannelExtent &mine = piece.channels[k], &wanted = first.channels[k];
    if (mine.label != wanted.label)
      problems.push_back(say("{}: channel '{}' stands where {} has '{}'", Name{piece.file}, mine.label,
                             Name{first.file}, wanted.label));
    else if (!(std::abs(mine.rate / wanted.rate - 1.0) < 1e-3))
      problems.push_back(
          say("{}: {} has {:.6g} Hz, and in {} {:.6g} Hz: write --set rate=... if one of them is "
              "wrong",
              Name{piece.file}, Name{mine.label}, mine.rate, Name{first.file}, wanted.rate));
  }
  return problems;
}

}  // namespace

std::string RecordPiece::to_bytes() const {
  StateWriter state;
  RecordPiece copy = *this;
  state(copy);
  return state.take();
}

RecordPiece RecordPiece::from_bytes(std::string_view bytes) {
  RecordPiece piece;
  StateReader state(bytes);
  state(piece);
  return piece;
}

RecordPiece measure_piece(const Plan& plan, const std::string& file, const Progress& progress) {
  NoiseExtent extent(plan);
  const Streamed streamed = stream_of(plan, file, progress);
  streamed.evidence.play([&](const Recording& block) { extent.push(block); });
  const Recording& header = *streamed.header;
  RecordPiece piece{.file = file, .instrument = header.instrument, .bytes = streamed.bytes};
  piece.channels = extent.channels();
  const TestTimes times = test_times(header.meta, *streamed.extent);
  piece.begun = times.begun;
  piece.ended = times.ended;
  if (const auto start = header.meta.find(clock_start); start != header.meta.end())
    if (const auto time = parse_iso_time(start->second); time && is_set(*time)) piece.clock_start = *time;
  Estimate noticed;
  noticed.method = plan.method;
  noticed.findings = header.findings;
  if (!noticed.findings.empty()) piece.findings = to_json(noticed);
  return piece;
}

namespace {

/// Samples of a channel that are missing before a file; a file that begins before the one before it ends is a problem,
/// which the first channel reports.
std::size_t lost_before(const RecordPiece& before, const RecordPiece& piece, std::size_t channel, Clock clock,
                        Problems& problems) {
  const Step step = step_between(before, piece, channel, clock);
  if (step.lost < -step.tolerance && channel == 0)
    problems.push_back(
        say("{}: begins {} before {} ends: give the files in the order of their times, each "
            "once",
            Name{piece.file}, Name{say_seconds(-step.lost / piece.channels[channel].rate)}, Name{before.file}));
  return step.lost > step.tolerance ? static_cast<std::size_t>(std::round(step.lost)) : 0;
}

/// Puts the samples of one channel one file behind the other.
void lay_out_channel(const std::vector<RecordPiece>& pieces, std::size_t channel, Clock clock, RecordLayout& layout,
                     Problems& problems) {
  std::size_t position = 0, lost = 0, gaps = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    PlaceInRecord place{.start = position};
    if (i > 0 && clock != Clock::none)
      place.lost_before = lost_before(pieces[i - 1], pieces[i], channel, clock, problems);
    lost += place.lost_before;
    gaps += place.lost_before > 0 ? 1 : 0;
    position += place.lost_before + pieces[i].channels[channel].samples;
    layout.places[i].push_back(place);
  }
  for (auto& places : layout.places) places[channel].total = position;
  if (gaps > 0)
    layout.findings.push_back({Finding::Severity::info,
                               "gaps_between_files",
                               {{"lost", lost}},
                               pieces.front().channels[channel].label,
                               {gaps, {}, {}}});
}

}  // namespace

RecordLayout lay_out(const std::vector<RecordPiece>& pieces) {
  Problems problems;
  for (const RecordPiece& piece : pieces)
    for (auto& problem : misfits(piece, pieces.front())) problems.push_back(std::move(problem));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  const Clock clock = clock_of(pieces);
  RecordLayout layout{std::vector<std::vector<PlaceInRecord>>(pieces.size()), {}};
  for (std::size_t k = 0; k < pieces.front().channels.size(); ++k) lay_out_channel(pieces, k, clock, layout, problems);
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  layout.findings.push_back({Finding::Severity::info,
                             clock == Clock::dates    ? "files_joined_by_dates"
                             : clock == Clock::stamps ? "files_joined_by_clock"
                                                      : "files_joined_without_times",
                             {{"files", pieces.size()}},
                             ""});
  return layout;
}

ReducedPiece reduce_piece(const Plan& plan, const std::string& file, const RecordPiece& piece,
                          const std::vector<PlaceInRecord>& places, const Progress& progress) {
  ReducedPiece reduced{NoisePart(plan, places), ""};
  const Streamed streamed = stream_of(plan, file, progress);
  NoiseExtent extent(plan);
  streamed.evidence.play([&](const Recording& block) {
    extent.push(block);
    reduced.part.push(block);
  });
  reduced.part.close();
  const auto channels = extent.channels();
  for (std::size_t k = 0; k < channels.size(); ++k)
    if (channels[k].samples != piece.channels[k].samples)
      throw Error(Error::Kind::bad_data, say("{}: has changed since it was measured: {} samples, before {}",
                                             Name{piece.file}, channels[k].samples, piece.channels[k].samples));
  reduced.sha256 = streamed.checksum();
  return reduced;
}

}  // namespace tumble
