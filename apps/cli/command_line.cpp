// The only file that knows CLI11.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <sstream>

#include "tumble/language/said.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/language/texts.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"
#include "tumble/version.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// --rate 100 and other words that are keys of --set.
Sentence set_instead(const CLI::App& app, const std::string& extra) {
  const auto names = option_names(app);
  if (std::ranges::find(names, "--set") == names.end()) return {};
  const auto equals = extra.find('=');
  const auto key = extra.substr(2, equals == std::string::npos ? equals : equals - 2);
  const std::vector<std::string> keys{"rate", "missing", "columns", "segment_column", "decimal"};
  if (std::ranges::find(keys, key) == keys.end()) return {};
  return say("; write --set {}={}", Name{key}, Name{equals == std::string::npos ? "VALUE" : extra.substr(equals + 1)});
}

/// What was on the command line that no option or argument takes, with the nearest that would.
[[noreturn]] void refuse_extras(const CLI::App& program) {
  const auto used = program.get_subcommands();
  const auto& app = used.empty() ? program : *used.front();
  const Name verb{used.empty() ? "" : app.get_name() + " "};
  std::vector<std::string> verbs;
  for (const auto* verb : program.get_subcommands({})) verbs.push_back(verb->get_name());
  Problems problems;
  for (const auto& extra : program.remaining(true)) {
    if (extra.starts_with("-")) {
      auto known = option_names(app);
      for (const auto& name : option_names(program)) known.push_back(name);
      problems.push_back(say("unknown option '{}'{} (see `tumble {}--help`)", extra,
                             set_instead(app, extra).empty() ? did_you_mean(extra, known) : set_instead(app, extra),
                             verb));
    } else if (used.empty()) {
      problems.push_back(
          say("unknown verb '{}'{} (verbs: {})", extra, did_you_mean(extra, verbs), fmt::join(verbs, ", ")));
      break;  // what follows was meant for it
    } else {
      problems.push_back(say("'{}' is one argument too many (see `tumble {}--help`)", extra, verb));
    }
  }
  throw Error(Error::Kind::bad_input, problems);
}

std::string seed_problem(const std::string& text) {
  const bool whole = as_number<std::uint64_t>(text).has_value();
  return whole ? std::string() : "a whole number from 0 to 18446744073709551615 is expected, not '" + text + "'";
}

/// Adds an argument to the verb that takes it.
struct Add {
  CLI::App& app;
  const Argument& argument;

  CLI::Option* operator()(bool* value) const { return app.add_flag(argument.name, *value, argument.description); }
  CLI::Option* operator()(std::string* value) const {
    return app.add_option(argument.name, *value, argument.description);
  }
  CLI::Option* operator()(std::vector<std::string>* value) const {
    auto* option = app.add_option(argument.name, *value, argument.description);
    if (argument.separator != 0) option->delimiter(argument.separator);
    if (argument.name.starts_with('-')) option->allow_extra_args(false);
    return option;
  }
  CLI::Option* operator()(std::uint64_t* value) const {
    auto* option = app.add_option(argument.name, *value, argument.description);
    if (argument.bytes.empty()) return option->check(seed_problem, "SEED")->capture_default_str();
    const auto not_below_zero = [](std::string& text) {
      return text.starts_with('-') ? "at least 0 is expected, not " + text : CLI::AsSizeValue(true)(text);
    };
    return option->transform(CLI::Validator(not_below_zero, ""))->default_str(argument.bytes);
  }
};

void add(CLI::App& app, const Argument& argument) {
  auto* option = std::visit(Add{app, argument}, argument.value);
  if (argument.required) option->required();
  if (!argument.type.empty()) option->type_name(argument.type);
  if (!argument.words.empty()) option->check(CLI::IsMember(argument.words));
}

/// `tumble help identify` is `tumble identify --help`; a word that is no verb stands alone, to be refused.
std::vector<std::string> words_of(int argc, char** argv, const std::vector<Verb>& verbs) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty() || words.front() != "help") return words;
  words.erase(words.begin());
  if (words.empty() || std::ranges::find(verbs, words.front(), &Verb::name) != verbs.end()) words.push_back("--help");
  return words;
}

}  // namespace

namespace {

/// What CLI11 writes into a help by itself, and the first and last line of the program's.
void speak(CLI::App& program, const std::vector<Verb>& verbs, Language language) {
  if (language == Language::english) return;
  const SectionWords words{language, "help"};
  const auto formatter = std::make_shared<CLI::Formatter>();
  for (const auto& [label, text] : texts_of(language, "help_labels")) formatter->label(label, text);
  const auto speak_of = [&](CLI::App& app) {
    app.formatter(formatter);
    app.set_help_flag("-h,--help", words("help"));
    for (auto* option : app.get_options()) option->group(words("options"));
  };
  speak_of(program);
  program.description(words("program"));
  program.footer(words("program_footer"));
  for (const char* name : {"version", "quiet", "lang"})
    program.get_option("--" + std::string(name))->description(words(name));
  const auto summaries = texts_of(language, "verb");
  for (const auto& verb : verbs) {
    auto* app = program.get_subcommand(verb.name);
    speak_of(*app);
    app->group(words("subcommands"));
    if (const auto found = summaries.find(verb.name); found != summaries.end()) app->description(found->second);
    for (const auto& argument : verb.arguments) {
      auto text = find_text(language, "argument." + verb.name, argument.name);
      if (!text) text = find_text(language, "argument.common", argument.name);
      const auto name = argument.name.substr(argument.name.rfind(',') + 1);  // "--output" of "-o,--output"
      if (text) app->get_option(name)->description(*text);
    }
  }
}

}  // namespace

int run_command_line(int argc, char** argv, const std::vector<Verb>& verbs, Terminal& terminal) {
  CLI::App program("Identify inertial instruments: from a plan and recordings to parameters with uncertainty.",
                   "tumble");
  program.set_version_flag("--version", fmt::format("tumble {}", version));
  program.add_flag("--quiet", terminal.quiet, "print only errors on standard error");
  std::string language;
  program.add_option("--lang", language, "of tables, findings and help: en or zh (default: as LANG says)")
      ->check(CLI::IsMember(language_codes()))
      ->type_name("LANGUAGE");
  program.fallthrough();
  program.require_subcommand(0, 1);  // behind a verb the name of another one is an argument: `tumble stop run`
  for (const auto& verb : verbs) {
    auto* app = program.add_subcommand(verb.name, verb.summary);
    for (const auto& argument : verb.arguments) add(*app, argument);
    app->footer(verb.footer);
  }
  program.footer("`tumble help VERB` describes a verb, with examples.");
  auto words = words_of(argc, argv, verbs);
  terminal.language = language_of_process(words);
  speak(program, verbs, terminal.language);
  try {
    std::ranges::reverse(words);  // as CLI11 wants them
    program.parse(std::move(words));
  } catch (const CLI::ExtrasError&) {
    refuse_extras(program);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      std::ostringstream text;
      const int status = program.exit(error, text, text);
      print(text.str());
      return status;
    }
    const auto used = program.get_subcommands();
    const std::string verb = used.empty() ? "" : used.front()->get_name() + " ";
    throw Error(Error::Kind::bad_input, say("{} (see `tumble {}--help`)", said_by_library(error.what()), Name{verb}));
  }
  for (const auto& verb : verbs)
    if (program.got_subcommand(verb.name)) return verb.run(terminal);
  std::fputs(program.help().c_str(), stderr);
  return usage;
}

}  // namespace tumble::cli
