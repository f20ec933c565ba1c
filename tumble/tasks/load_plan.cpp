#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "tumble/core/tables/document.hpp"
#include "tumble/core/tables/section.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/kind_of_file.hpp"
#include "tumble/tasks/plan_file/beside.hpp"
#include "tumble/tasks/plan_file/check_schedule.hpp"
#include "tumble/tasks/plan_file/file_named.hpp"
#include "tumble/tasks/plan_file/files_like.hpp"
#include "tumble/tasks/plan_file/limits.hpp"
#include "tumble/tasks/plan_file/prior.hpp"
#include "tumble/tasks/plan_file/reading.hpp"
#include "tumble/tasks/plan_file/recording_entry.hpp"
#include "tumble/tasks/plan_file/schedule.hpp"
#include "tumble/tasks/plan_file/site.hpp"
#include "tumble/tasks/plan_text.hpp"
#include "tumble/tasks/sets.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using plan_file::files_like;
using plan_file::look_up;
using plan_file::Reading;
using plan_file::resolve_section;
using tables::Section;

Plan load(const std::string& path, const Sets& sets, bool part);

void read_instrument(Reading& reading, const toml::table& table) {
  Section section(table, "[instrument]", reading.problems);
  reading.plan.instrument_model = section.text("model").value_or("");
  const auto serial = section.text("serial");
  reading.plan.instrument_serial = reading.sets.serial.value_or(serial.value_or(""));
  reading.plan.sample_rate = section.quantity("rate", Unit::parse("Hz")).value_or(0.0);
  if (table.contains("rate") && table.get("rate")->is_string() && !(reading.plan.sample_rate > 0.0))
    section.problem_at("rate", "must be above zero");
  if (!reading.plan.instrument_model.empty())
    reading.model = look_up(
        section, "model", [&]() -> auto& { return find_model(reading.plan.instrument_model); });
  section.close();
}

void read_rig(Reading& reading, const toml::table& table) {
  Section section(table, "[rig]", reading.problems);
  const auto kind = section.text("kind");
  reading.plan.rig_equipment = section.text("equipment").value_or("");
  if (!table.contains("kind")) section.missing("kind", "\"thermal_chamber\"");
  if (!kind) return;
  reading.plan.rig_kind = *kind;
  reading.rig = look_up(
      section, "kind", [&]() -> auto& { return find_rig(*kind); });
  if (reading.rig)
    reading.plan.rig =
        resolve_section(reading, section, reading.rig->options(), say("rig {}", Name{*kind}), reading.sets.rig);
}

bool takes_several(const Reading& reading, const std::string& name) {
  if (!reading.method) return true;
  const auto roles = reading.method->roles();
  return std::any_of(roles.begin(), roles.end(), [&](const Role& role) { return role.name == name && role.several; });
}

void read_channels(Reading& reading, const toml::table& table) {
  Section section(table, "[channels]", reading.problems);
  std::vector<Role> roles;
  if (reading.method) roles = reading.method->roles();
  std::vector<std::string> names;
  for (const auto& role : roles) names.push_back(role.name);
  if (!reading.method) names = section.unread();
  for (const auto& name : names) {
    for (const auto& text : section.texts(name)) try {
        reading.plan.channels[name].push_back(parse_choice(text));
      } catch (const Error& error) {
        for (const auto& problem : error.problems) section.problem_at(name, problem);
      }
    if (const auto given = reading.plan.channels.find(name);
        given != reading.plan.channels.end() && given->second.size() > 1 && !takes_several(reading, name))
      section.problem_at(name, "only one channel can have this role");
  }
  section.close();
}

bool has_option(const Method& method, std::string_view name) {
  const auto options = method.options();
  return std::any_of(options.begin(), options.end(), [&](const Option& option) { return option.name == name; });
}

/// The settings of the command line. A rate is meant for the reader alone, unless the method has such an option.
std::vector<Given> settings_given(const Reading& reading) {
  auto settings = reading.sets.settings;
  if (!has_option(*reading.method, "rate")) std::erase_if(settings, [](const Given& one) { return one.key == "rate"; });
  return settings;
}

void read_settings(Reading& reading, const toml::table& table) {
  Section section(table, "[settings]", reading.problems);
  if (reading.method)
    reading.plan.settings = resolve_section(reading, section, reading.method->options(),
                                            say("method {}", Name{reading.plan.method}), settings_given(reading));
  else if (reading.plan.method.empty() && !table.empty())
    section.problem("needs the plan's method: method = \"...\" at the top");
}

void read_truth(Reading& reading, const toml::table& table) {
  Section section(table, "[truth]", reading.problems);
  if (reading.model)
    reading.plan.truth = resolve_section(reading, section, truth_options(*reading.model),
                                         say("model {}", Name{reading.plan.instrument_model}), reading.sets.truth);
  else if (reading.plan.instrument_model.empty())
    section.problem("needs the instrument's model: [instrument] model = \"...\"");
}

/// The plan of a recording that was made on another rig, or by another schedule, with the same instrument.
std::shared_ptr<const Plan> plan_of_recording(Reading& reading, Section& section, const std::string& file) {
  if (reading.part) {
    section.problem_at("plan", "the plan of a recording cannot name further plans");
    return nullptr;
  }
  const auto& model = reading.plan.instrument_model;
  try {
    auto plan = load(file, {}, true);
    if (plan.instrument_model == model || (reading.method && reading.method->several_instruments))
      return std::make_shared<const Plan>(std::move(plan));
    section.problem_at(
        "plan", say("{} is for a '{}', this plan is for a '{}': all recordings must be of one instrument", Name{file},
                    plan.instrument_model, model));
  } catch (const Error& error) {
    for (const auto& problem : error.problems) reading.problems.all.push_back(problem);
  }
  return nullptr;
}

std::vector<std::string> labels_of(const Schedule& schedule) {
  std::vector<std::string> labels;
  for (const auto& segment : schedule) labels.push_back(segment.label);
  return labels;
}

void read_recordings(Reading& reading, const toml::array& tables) {
  const auto folder = std::filesystem::path(reading.plan.file).parent_path();
  for (const auto& node : tables) {
    Section section(*node.as_table(), "[[recording]]", reading.problems);
    RecordingEntry entry = plan_file::read_recording_entry(section, folder);
    if (const auto plan = plan_file::file_named(section, "plan", folder)) {
      const auto [part, unread] = reading.parts.try_emplace(*plan);
      if (unread) part->second = plan_of_recording(reading, section, part->first);
      entry.plan = part->second;  // recordings that name one file are parts of one test on one rig
    }
    const auto labels = labels_of(entry.plan ? entry.plan->schedule : reading.plan.schedule);
    if (!entry.segment.empty() && std::find(labels.begin(), labels.end(), entry.segment) == labels.end()) {
      section.problem_at("segment",
                         say("the schedule has no segment '{}'{}", entry.segment, did_you_mean(entry.segment, labels)));
    }
    section.close();
    const auto files = files_like(entry.file);
    if (files.empty()) section.problem_at("file", say("no file is called like {}", Name{entry.file}));
    for (const auto& one : files) {
      entry.file = one;
      reading.plan.recordings.push_back(entry);
    }
  }
}

/// The array of tables of that name; a problem, and null, when something else stands there.
const toml::array* tables(Section& root, const char* key) {
  const auto* node = root.find(key);
  if (!node) return nullptr;
  const auto* array = node->as_array();
  const bool good = array && std::all_of(array->begin(), array->end(), [](const auto& one) { return one.is_table(); });
  if (!good) root.problem_at(key, say("is a list of tables, each headed [[{}]]", key));
  return good ? array : nullptr;
}

void read_schedule(Reading& reading, Section& root) {
  const auto before = reading.problems.all.size();
  if (const auto* array = tables(root, "schedule"))
    reading.plan.schedule = plan_file::read_schedule(*array, reading.rig, reading.problems);
  reading.clean_schedule = reading.problems.all.size() == before && !reading.plan.rig.texts().empty();
}

void read_channel_sets(Reading& reading) {
  std::vector<std::string> roles;
  if (reading.method)
    for (const auto& role : reading.method->roles()) roles.push_back(role.name);
  for (const auto& [role, text] : reading.sets.channels) try {
      if (reading.method && std::find(roles.begin(), roles.end(), role) == roles.end())
        throw Error(Error::Kind::bad_input, say("{} has no such role{} (roles: {})", Name{reading.plan.method},
                                                did_you_mean(role, roles), fmt::join(roles, ", ")));
      auto choices = parse_choices(text);
      if (choices.size() > 1 && !takes_several(reading, role))
        throw Error(Error::Kind::bad_input, "only one channel can have this role");
      reading.plan.channels[role] = std::move(choices);
    } catch (const Error& error) {
      for (const auto& problem : error.problems)
        reading.problems.all.push_back(within(say("--set channels.{}", Name{role}), problem));
    }
}

/// The result that the method builds on: relative to the plan, or as the command line says, which wins.
void read_calibration(Reading& reading, Section& root) {
  const auto& set = reading.sets.calibration;
  const auto folder = std::filesystem::path(reading.plan.file).parent_path();
  const auto text = plan_file::file_named(root, "calibration", folder);
  if (text) reading.plan.calibration.file = *text;
  if (set) reading.plan.calibration.file = *set;
  if ((!text && !set) || !reading.method || reading.method->takes_calibration) return;
  const auto problem = say("{} does not use a calibration", Name{reading.plan.method});
  if (set) reading.problems.all.push_back(say("--set calibration: {}", problem));
  if (text) root.problem_at("calibration", problem);
}

/// The prior of the plan, or as the command line says, which wins.
void read_prior(Reading& reading, Section& root) {
  reading.plan.prior = plan_file::read_prior(root, std::filesystem::path(reading.plan.file).parent_path().string(),
                                             reading.method, reading.problems);
  if (!reading.sets.prior) return;
  reading.plan.prior.from = *reading.sets.prior;
  if (const auto refusal = reading.method ? plan_file::refusal_of_prior(*reading.method) : Sentence(); !refusal.empty())
    reading.problems.all.push_back(say("--set prior: {}", refusal));
}

void read_sections(Reading& reading, const toml::table& document) {
  static const toml::table nothing;
  Section root(document, "", reading.problems);
  const auto section = [&](const char* key) -> const toml::table& {
    const auto* table = root.table(key);
    return table ? *table : nothing;
  };
  const auto given = [&](const char* key) { return document.contains(key); };
  reading.plan.title = root.text("title").value_or("");
  reading.plan.method = root.text("method").value_or("");
  if (!reading.plan.method.empty())
    reading.method = look_up(
        root, "method", [&]() -> auto& { return find_method(reading.plan.method); });
  read_calibration(reading, root);
  read_prior(reading, root);
  read_instrument(reading, section("instrument"));
  if (const auto& site = section("site"); given("site"))
    reading.plan.site = plan_file::read_site(site, reading.problems);
  if (const auto& rig = section("rig"); given("rig")) read_rig(reading, rig);
  read_schedule(reading, root);
  read_channels(reading, section("channels"));
  read_channel_sets(reading);
  if (const auto* array = tables(root, "recording")) read_recordings(reading, *array);
  if (reading.rig && reading.clean_schedule)
    plan_file::check_schedule(reading.plan, *reading.rig, root, reading.problems);
  read_settings(reading, section("settings"));
  if (const auto* array = tables(root, "limit")) reading.plan.limits = plan_file::read_limits(*array, reading.problems);
  const auto& truth = section("truth");
  if (given("truth") || !reading.sets.truth.empty()) read_truth(reading, truth);
  if (given("beside") || !reading.sets.beside.empty()) plan_file::read_beside(reading, section("beside"), truth);
  if (!reading.sets.rig.empty() && !given("rig"))
    reading.problems.all.push_back(say("--set rig.{}: the plan has no [rig]", Name{reading.sets.rig.front().key}));
  root.close();
}

}  // namespace

namespace {

/// What an answer states of the plan that it follows.
void note_source(Plan& plan, const std::string& text, const Sets& sets) {
  constexpr std::size_t longest = 100'000;
  plan.sha256 = sha256_of(text);
  if (text.size() <= longest) plan.text = text;
  for (const auto& [key, value] : sets) plan.command_line[key] = value;
}

Plan plan_of(const std::string& text, const std::string& path, const Sets& sets, bool part) {
  Reading reading;
  reading.part = part;
  reading.plan.file = reading.problems.file = path;
  const auto document = tables::document_of(text, path);
  note_source(reading.plan, text, sets);
  reading.sets = sorted(sets);
  reading.plan.reading = reading.sets.reading;
  read_sections(reading, document);
  if (!reading.problems.all.empty()) throw Error(Error::Kind::bad_input, reading.problems.sorted());
  return reading.plan;
}

Plan load(const std::string& path, const Sets& sets, bool part) {
  refuse_other_kind(path, FileKind::plan);
  return plan_of(read_text_file(path), path, sets, part);
}

}  // namespace

Plan plan_of_text(const std::string& text, const std::string& path) { return plan_of(text, path, {}, false); }

Plan load_plan(const std::string& path, const Sets& sets) { return load(path, sets, false); }

Plan plan_for_method(const std::string& name, const Sets& sets) {
  const auto& method = find_method(name);
  if (method.needs_plan)
    throw Error(Error::Kind::bad_input,
                say("{0} needs a plan that says how the rig moved: a file with method = \"{0}\"", Name{name}));
  Reading reading;
  reading.plan.method = name;
  for (const auto& [key, value] : sets) reading.plan.command_line[key] = value;
  reading.method = &method;
  reading.sets = sorted(sets);
  reading.plan.reading = reading.sets.reading;
  reading.plan.instrument_serial = reading.sets.serial.value_or("");
  reading.plan.settings =
      resolve(method.options(), settings_given(reading), say("method {}", Name{name}), reading.problems.all);
  if (reading.sets.calibration && !method.takes_calibration)
    reading.problems.all.push_back(say("--set calibration: {} does not use a calibration", Name{name}));
  reading.plan.calibration.file = reading.sets.calibration.value_or("");
  if (const auto refusal = plan_file::refusal_of_prior(method); reading.sets.prior && !refusal.empty())
    reading.problems.all.push_back(say("--set prior: {}", refusal));
  reading.plan.prior.from = reading.sets.prior.value_or("");
  const std::pair<const char*, const std::vector<Given>*> of_plans[]{
      {"truth.", &reading.sets.truth}, {"rig.", &reading.sets.rig}, {"beside.", &reading.sets.beside}};
  for (const auto& [prefix, sets_of_plan] : of_plans)
    for (const auto& given : *sets_of_plan)
      reading.problems.all.push_back(say("--set {}: there is no plan that it could change", Name{prefix + given.key}));
  read_channel_sets(reading);
  if (!reading.problems.all.empty()) throw Error(Error::Kind::bad_input, reading.problems.all);
  return reading.plan;
}

}  // namespace tumble
