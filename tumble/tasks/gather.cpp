#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/core/roles.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/conflicts.hpp"
#include "tumble/tasks/calibration.hpp"
#include "tumble/tasks/clock_column.hpp"
#include "tumble/tasks/copies.hpp"
#include "tumble/tasks/marks.hpp"
#include "tumble/tasks/prior.hpp"
#include "tumble/tasks/streamed.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// The columns that play a role, as the plan says or by the role's own name.
std::vector<std::string> columns_of(const Plan& plan, const Role& role) {
  const auto choices = plan.channels.find(role.name);
  if (choices == plan.channels.end()) return names_of_role(role.name);
  std::vector<std::string> columns;
  for (const auto& choice : choices->second) columns.push_back(choice.channel);
  return columns;
}

/// Whether it cannot be known before a file is read which of its columns play the role.
bool open_ended(const Plan& plan, const Role& role) { return role.several && !plan.channels.contains(role.name); }

/// The encoders of all axes that the schedules name, which identify() looks at for every method.
std::vector<std::string> encoders_of(const Plan& plan) {
  std::set<std::string> axes;
  const auto add = [&](const Plan& one) {
    for (const Segment& segment : one.schedule)
      for (const auto& [axis, motion] : segment.axes) axes.insert(axis);
  };
  add(plan);
  for (const RecordingEntry& entry : plan.recordings)
    if (entry.plan) add(*entry.plan);
  std::vector<std::string> columns;
  for (const std::string& axis : axes)
    for (auto& column : columns_of(plan, Role{axis + "_angle", "", false, ""})) columns.push_back(std::move(column));
  return columns;
}

/// What to read: with a method that names the channels it needs, those alone; else all.
ReadOptions options_for(const Plan& plan, const std::vector<Role>& roles) {
  auto options = plan.reading;
  if (!options.rate && plan.sample_rate > 0.0) options.rate = plan.sample_rate;
  for (const auto& [role, choices] : plan.channels)
    for (const auto& choice : choices)
      if (choice.unit) options.units.try_emplace(choice.channel, *choice.unit);
  if (std::any_of(roles.begin(), roles.end(), [&](const Role& role) { return open_ended(plan, role); })) return options;
  if (std::any_of(roles.begin(), roles.end(), [](const Role& role) { return role.required; }))
    for (const auto& role : roles)
      for (auto& column : columns_of(plan, role)) options.only.push_back(std::move(column));
  if (!options.only.empty())
    for (auto& column : encoders_of(plan)) options.only.push_back(std::move(column));
  return options;
}

std::vector<NamedKind> columns_of(const std::vector<Channel>& channels) {
  std::vector<NamedKind> columns;
  for (const auto& channel : channels) columns.push_back({channel.name, channel.kind});
  return columns;
}

std::vector<std::string> names_of(const std::vector<NamedKind>& columns) {
  std::vector<std::string> names;
  for (const auto& column : columns) names.push_back(column.name);
  return names;
}

/// What the column of a role holds: words of the program.
Sentence role_words(const Role& role) { return Sentence(std::string(role.description).c_str()); }

/// The columns of a file for a message: a second look, since only those of the roles were read. The first block says
/// them, and the file may be larger than memory.
std::vector<NamedKind> columns_in(const Recording& recording, ReadOptions options) {
  struct Known {
    std::vector<NamedKind> columns;
  };
  const std::string& file = recording.origin.file;
  options.only.clear();
  try {
    stream_recording(format_of(file, options), file, options, 1,
                     [](const Recording& block) { throw Known{columns_of(block.channels)}; }, {});
  } catch (const Known& known) {
    return known.columns;
  } catch (const Error&) {
  }
  return columns_of(recording.channels);
}

Problem missing_channel(const Plan& plan, const Role& role, const std::string& wanted, const Recording& recording,
                        const std::vector<std::string>& columns) {
  const Sentence how = plan.file.empty() ? say("--set channels.{}=...", Name{role.name})
                                         : say("[channels] {} = \"...\" in {}", Name{role.name}, Name{plan.file});
  return in_file(recording.origin.file,
                 say("no column '{}' for {} ({}){}; columns are {}; name the right one with {}", wanted,
                     Name{role.name}, role_words(role), did_you_mean(wanted, columns), fmt::join(columns, ", "), how));
}

/// A role that no column plays.
struct MissingRole {
  const Role* role;
  std::string wanted;  ///< the column that should
};

/// A problem for each, and at the end what the names of the columns propose for all roles.
void report_missing(const Plan& plan, const std::vector<Role>& roles, const std::vector<MissingRole>& missing,
                    const Recording& recording, const ReadOptions& options, Problems& problems) {
  if (missing.empty()) return;
  const auto columns = columns_in(recording, options);
  const auto names = names_of(columns);
  for (const auto& [role, wanted] : missing) problems.push_back(missing_channel(plan, *role, wanted, recording, names));
  std::string proposal;
  for (const auto& [role, channel] : proposed_roles(columns))
    if (!plan.channels.contains(role) && std::ranges::find(roles, role, &Role::name) != roles.end())
      proposal += plan.file.empty() ? fmt::format(" --set channels.{}={}", role, channel)
                                    : fmt::format("{}{} = \"{}\"", proposal.empty() ? " " : "; ", role, channel);
  if (!proposal.empty())
    problems.push_back(
        in_file(recording.origin.file,
                say("by the names of its columns{}:{}",
                    plan.file.empty() ? Sentence() : say(", in [channels] of {}", Name{plan.file}), Name{proposal})));
}

/// What is wrong with the unit of a channel in a role.
std::optional<Problem> wrong_unit(const Role& role, const Channel& channel, const Recording& recording) {
  if (role.unit.empty()) return std::nullopt;
  const auto expected = Unit::parse(role.unit);
  if (channel.unit.dimension() == expected.dimension()) return std::nullopt;
  return in_file(
      recording.origin.file,
      say("column '{}' is in {} [{}], but {} ({}) must be in {} or another unit of [{}]; correct the unit in "
          "the file, or name another column",
          channel.name, Name{channel.unit.text()}, Name{name(channel.unit.dimension())}, Name{role.name},
          role_words(role), Name{std::string(role.unit)}, Name{name(expected.dimension())}));
}

/// Reads what the roles need. A file that has none of it is read whole: then what it lacks is said with what it has.
Recording read(const std::string& file, const ReadOptions& options, const Progress& progress) try {
  return read_recording(file, options, progress);
} catch (const Error&) {
  if (options.only.empty()) throw;
  auto all = options;
  all.only.clear();
  try {
    return read_recording(file, all, progress);
  } catch (const Error&) {
  }
  throw;
}

/// What the entry of the plan says of its file, unless the command line does.
ReadOptions options_of(const RecordingEntry& entry, const Plan& plan, ReadOptions options) {
  if (entry.plan && entry.plan->sample_rate > 0.0 && !plan.reading.rate) options.rate = entry.plan->sample_rate;
  if (options.columns.empty()) options.columns = entry.columns;
  if (options.segment_column.empty()) options.segment_column = entry.segment_column;
  if (options.topics.empty()) options.topics = entry.topics;
  if (options.frames.empty()) options.frames = entry.frames;
  if (options.decimal == '\0') options.decimal = entry.decimal;
  if (options.time.empty()) options.time = entry.time;
  if (options.date.empty()) options.date = entry.date;
  if (options.encoding.empty()) options.encoding = entry.encoding;
  if (options.skip == 0) options.skip = entry.skip;
  return options;
}

/// `read_by`: how each recording was read.
void check_roles(const Evidence& evidence, const std::vector<Role>& roles, const std::vector<ReadOptions>& read_by) {
  Problems problems;
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    const auto& recording = evidence.recordings[r];
    const auto& options = read_by[r];
    const bool part = evidence.plans[r] && !evidence.plans[r]->channels.empty();  // says itself what it holds
    for (auto& problem : unit_conflicts(recording, options)) problems.push_back(std::move(problem));
    std::vector<MissingRole> missing;
    Problems wrong_units;
    for (const auto& role : roles) {
      const auto channels = role.several ? channels_for(evidence, recording, role.name)
                                         : std::vector{channel_for(evidence, recording, role.name)};
      for (const auto* channel : channels)
        if (channel)
          if (auto problem = wrong_unit(role, *channel, recording)) wrong_units.push_back(std::move(*problem));
      const bool named = !part && evidence.plan.channels.contains(role.name);
      if (!named && (!role.required || (!channels.empty() && channels.front()))) continue;
      for (const auto& column : named ? columns_of(evidence.plan, role) : std::vector{role.name})
        if (!find_channel(recording, column)) missing.push_back({&role, column});
    }
    report_missing(evidence.plan, roles, missing, recording, options, problems);
    problems.insert(problems.end(), wrong_units.begin(), wrong_units.end());
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// What the command line says of reading must be of use for some file.
void check_reading(const ReadOptions& said, const Evidence& evidence, const std::vector<ReadOptions>& read_by) {
  Problems problems;
  for (const auto& [column, unit] : said.units) {
    std::vector<std::string> known;
    for (std::size_t r = 0; r < evidence.recordings.size(); ++r)
      for (auto& name : find_channel(evidence.recordings[r], column)
                            ? std::vector{column}
                            : names_of(columns_in(evidence.recordings[r], read_by[r])))
        known.push_back(std::move(name));
    const auto meant = [&](const std::string& name) { return name == column || name.starts_with(column + "."); };
    bool used = std::ranges::any_of(known, meant);
    for (std::size_t r = 0; r < evidence.recordings.size() && !used; ++r)
      used = is_clock_column(column, evidence.recordings[r].origin.file, read_by[r]);
    if (!used)
      problems.push_back(
          say("--set unit.{}: no file has a column '{}'{}", Name{column}, column, did_you_mean(column, known)));
  }
  for (const auto& recording : evidence.recordings)
    if (said.rate)
      if (auto problem = rate_conflict(recording, *said.rate)) problems.push_back(std::move(*problem));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

/// Of a recording that was in memory already, what options_for() would have had read from a file.
void select_channels(const std::vector<std::string>& only, Recording& recording) {
  const auto wanted = [&](const Channel& channel) { return std::ranges::find(only, channel.name) != only.end(); };
  if (std::ranges::any_of(recording.channels, wanted))
    std::erase_if(recording.channels, [&](const Channel& channel) { return !wanted(channel); });
}

/// The files of the plan and those named after it; there must be one, unless recordings are in memory.
std::vector<RecordingEntry> entries_of(const Plan& plan, const std::vector<std::string>& files, bool in_memory) {
  auto entries = plan.recordings;
  for (const auto& file : files) entries.push_back({file, "", 0, nullptr});
  if (entries.empty() && !in_memory)
    throw Error(Error::Kind::bad_input,
                plan.file.empty() ? Problem("no recording to identify from: name one or more after the method")
                                  : in_file(plan.file, "no recording: name it after the plan or in [[recording]]"));
  return entries;
}

/// Evidence, and how each of its recordings was read.
struct Gathered {
  Evidence evidence;
  std::vector<ReadOptions> read_by = {};

  /// Takes a recording whose plan and options stand already.
  void accept(Recording recording, const RecordingEntry& entry) {
    evidence.recordings.push_back(std::move(recording));
    mark_from_schedule(plan_of(evidence, evidence.recordings.size() - 1), entry, evidence.recordings.back());
    end_marks(plan_of(evidence, evidence.recordings.size() - 1).schedule, evidence.recordings.back().marks);
  }
};

/// Reads all files; what cannot be read is refused together.
void read_files(const std::vector<RecordingEntry>& entries, const ReadOptions& options, const Progress& progress,
                Gathered& to) {
  Problems problems;
  auto kind = Error::Kind::bad_file;
  for (std::size_t i = 0; i < entries.size(); ++i) try {
      const auto part = [&](double done, std::string_view what) {
        report(progress, (static_cast<double>(i) + done) / static_cast<double>(entries.size()), what);
      };
      to.evidence.plans.push_back(entries[i].plan);
      to.read_by.push_back(options_of(entries[i], to.evidence.plan, options));
      to.accept(read(entries[i].file, to.read_by.back(), part), entries[i]);
      // One thread at a time works out its own.
      if (entries.size() > 1) sha256_of(to.evidence.recordings.back().origin);
    } catch (const Error& error) {
      kind = error.kind;
      problems.insert(problems.end(), error.problems.begin(), error.problems.end());
    }
  if (!problems.empty()) throw Error(kind, problems);
}

void take_from_memory(std::vector<Recording> recordings, const ReadOptions& options, Gathered& to) {
  for (auto& recording : recordings) {
    to.evidence.plans.push_back(nullptr);
    to.read_by.push_back({});
    for (Channel& channel : recording.channels)
      if (!channel.timeline.uniform() && options.rate) channel.timeline.rate = *options.rate;
    to.accept(std::move(recording), {});
  }
}

/// Gathers the files, then takes the recordings in memory.
Evidence gather_all(Plan plan, const std::vector<std::string>& files, std::vector<Recording> in_memory,
                    const Progress& progress) {
  if (plan.method.empty())
    throw Error(Error::Kind::bad_input, say("{}: names no method: method = \"...\" at the top", Name{plan.file}));
  const auto roles = find_method(plan.method).roles();
  const auto options = options_for(plan, roles);
  const auto entries = entries_of(plan, files, !in_memory.empty());
  read_calibration(plan);
  read_prior(plan);
  Gathered gathered{{std::move(plan), {}}};
  Evidence& evidence = gathered.evidence;
  read_files(entries, options, progress, gathered);
  check_reading(evidence.plan.reading, evidence, gathered.read_by);
  take_from_memory(std::move(in_memory), options, gathered);
  look_at_copies(evidence.recordings);
  check_roles(evidence, roles, gathered.read_by);
  for (std::size_t r = entries.size(); r < evidence.recordings.size(); ++r)
    select_channels(options.only, evidence.recordings[r]);
  return std::move(evidence);
}

}  // namespace

Evidence gather(Plan plan, const std::vector<std::string>& recordings, const Progress& progress) {
  return gather_all(std::move(plan), recordings, {}, progress);
}

Evidence gather(Plan plan, const std::vector<std::string>& files, std::vector<Recording> in_memory,
                const Progress& progress) {
  return gather_all(std::move(plan), files, std::move(in_memory), progress);
}

namespace {

constexpr std::size_t block_samples = std::size_t{1} << 18;

/// Everything but the samples, checked as a whole recording is.
Recording header_of(const Recording& block, const Plan& plan, const RecordingEntry& entry, const ReadOptions& options) {
  Recording header{block.instrument, {}, block.marks, block.origin, block.meta, block.findings};
  for (const auto& channel : block.channels)
    header.channels.push_back({channel.name, channel.kind, channel.unit, channel.timeline, {}});
  mark_from_schedule(plan, entry, header);
  if (const auto runs = runs_of({header}).size(); runs > 1)
    throw Error(Error::Kind::unsupported,
                say("{} holds {} power-ups and is too large for memory: only a single power-up can be "
                    "processed in blocks; write each power-up to its own file, or raise --memory-limit",
                    Name{entry.file}, runs));
  check_roles({plan, {header}, {nullptr}}, find_method(plan.method).roles(), {options});
  return header;
}

/// Bytes of the samples in memory; 0 where the file cannot be read, which gather() says better.
std::uintmax_t memory_of(const std::string& file, const ReadOptions& options) try {
  return recording_memory(format_of(file, options), file, options);
} catch (const Error&) {
  return 0;
}

}  // namespace

std::optional<Streamed> open_stream(const Plan& plan, const std::vector<std::string>& recordings, std::uintmax_t memory,
                                    const Progress& progress) {
  if (plan.method.empty() || !find_method(plan.method).stream || plan.recordings.size() + recordings.size() != 1)
    return std::nullopt;
  const RecordingEntry entry =
      plan.recordings.empty() ? RecordingEntry{recordings[0], "", 0, nullptr} : plan.recordings[0];
  if (entry.plan) return std::nullopt;
  const auto options = options_of(entry, plan, options_for(plan, find_method(plan.method).roles()));
  Streamed streamed;
  streamed.bytes = memory_of(entry.file, options);
  if (streamed.bytes <= memory) return std::nullopt;
  const auto header = std::make_shared<Recording>();
  const auto extent = std::make_shared<Extent>();
  streamed.header = header, streamed.extent = extent;
  streamed.checksum = sha256_in_background(entry.file);
  streamed.file = entry.file;
  streamed.evidence.plan = plan;
  read_calibration(streamed.evidence.plan);
  read_prior(streamed.evidence.plan);
  streamed.evidence.play = [=](const BlockSink& sink) {
    bool first = true;
    const auto checked = [&](const Recording& block) {
      if (first) *header = header_of(block, plan, entry, options), *extent = {};
      first = false;
      extent->add(block);
      sink(block);
    };
    stream_recording(format_of(entry.file, options), entry.file, options, block_samples, checked, progress);
  };
  return streamed;
}

}  // namespace tumble
