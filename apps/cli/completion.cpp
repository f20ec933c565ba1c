// Words for the shells, made from the verbs' own options, so that nothing is said twice.

#include "completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "tumble/exchange/exports/export.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/tasks/catalogue.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/units/error.hpp"

namespace tumble::cli {
namespace {

/// "--output" and "-o" of "-o,--output"; nothing of an argument without a dash.
std::vector<std::string> names_of(const Argument& argument) {
  std::vector<std::string> names;
  std::string_view rest = argument.name;
  while (!rest.empty()) {
    const auto name = rest.substr(0, rest.find(','));
    if (name.starts_with('-')) names.emplace_back(name);
    rest.remove_prefix(std::min(rest.size(), name.size() + 1));
  }
  return names;
}

std::vector<std::string> options_of(const Verb& verb) {
  std::vector<std::string> options{"--help", "--quiet"};
  for (const auto& argument : verb.arguments)
    for (const auto& name : names_of(argument)) options.push_back(name);
  return options;
}

/// What may stand in the first place of a verb besides a file.
std::vector<std::string> first_words_of(const Verb& verb) {
  std::vector<std::string> words;
  if (verb.name == "list") words = catalogue_kinds();
  if (verb.name == "identify" || verb.name == "init")
    for (const auto* method : method_catalogue()) words.emplace_back(method->name);
  for (const auto& argument : verb.arguments)
    if (!argument.name.starts_with('-')) {
      words.insert(words.end(), argument.words.begin(), argument.words.end());
      words.insert(words.end(), argument.actions.begin(), argument.actions.end());
      break;
    }
  if (verb.name == "init")
    for (const auto& plan : ready_plans())
      if (std::ranges::find(words, plan.name) == words.end()) words.emplace_back(plan.name);
  return words;
}

/// What may follow an option; empty: any text, or a file.
std::vector<std::string> values_of(const Verb& verb, const Argument& argument) {
  std::vector<std::string> words = argument.words;
  if (verb.name == "export" && argument.name == "--to")
    for (const Export* consumer : export_catalogue()) words.emplace_back(consumer->name);
  if (verb.name == "export" && argument.name == "--drop")
    for (const CalibrationTerm& term : calibration_terms()) words.emplace_back(term.name);
  if (verb.name == "certificate" && argument.name == "--rule")
    words = {"simple", "guarded:1", "risk:0.025", "method6", "non-binary"};
  return words;
}

/// "--to) values=\"kalibr openvins\" ;; " for each option that takes one of a few words.
std::string bash_values(const Verb& verb) {
  std::string cases;
  for (const auto& argument : verb.arguments)
    if (const auto values = values_of(verb, argument); !values.empty() && argument.name.starts_with('-'))
      cases += fmt::format("{}) values=\"{}\" ;; ", fmt::join(names_of(argument), "|"), fmt::join(values, " "));
  return cases.empty() ? "" : fmt::format("\n      case \"$before\" in {}esac", cases);
}

std::vector<std::string> verb_names(const std::vector<Verb>& verbs) {
  std::vector<std::string> names{"help"};
  for (const auto& verb : verbs) names.push_back(verb.name);
  return names;
}

std::string bash(const std::vector<Verb>& verbs) {
  std::string cases;
  for (const auto& verb : verbs)
    cases += fmt::format("    {}) options=\"{}\" words=\"{}\"{} ;;\n", verb.name, fmt::join(options_of(verb), " "),
                         fmt::join(first_words_of(verb), " "), bash_values(verb));
  return fmt::format(
      "_tumble() {{\n"
      "  local word=\"${{COMP_WORDS[COMP_CWORD]}}\" before=\"${{COMP_WORDS[COMP_CWORD-1]}}\" options=\"\" words=\"\" "
      "values=\"\"\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ] || [ \"${{COMP_WORDS[1]}}\" = help ]; then\n"
      "    COMPREPLY=($(compgen -W \"{} --help --version\" -- \"$word\"))\n    return\n  fi\n"
      "  case \"${{COMP_WORDS[1]}}\" in\n{}  esac\n"
      "  if [ -n \"$values\" ]; then\n    COMPREPLY=($(compgen -W \"$values\" -- \"$word\"))\n    return\n  fi\n"
      "  case \"$word\" in\n"
      "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
      "    *) [ \"$COMP_CWORD\" -eq 2 ] || words=\"\"\n"
      "       COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
      "       local IFS=$'\\n'\n"
      "       COMPREPLY+=($(compgen -f -- \"$word\")) ;;\n"
      "  esac\n}}\ncomplete -o filenames -F _tumble tumble\n",
      fmt::join(verb_names(verbs), " "), cases);
}

std::string zsh(const std::vector<Verb>& verbs) {
  return "#compdef tumble\nautoload -U +X bashcompinit && bashcompinit\n" + bash(verbs) +
         "# Called for the first time, as a function that zsh loads, this file completes too.\n"
         "[ \"${funcstack[1]}\" != _tumble ] || _bash_complete -o filenames -F _tumble\n";
}

/// 'text' for fish.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text)
    result += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c == '\n' ? ' ' : c);
  return result + "'";
}

std::string fish(const std::vector<Verb>& verbs) {
  std::string text = "complete -c tumble -n __fish_use_subcommand -f -a help -d 'Describe a verb'\n";
  for (const auto& verb : verbs) {
    text +=
        fmt::format("complete -c tumble -n __fish_use_subcommand -f -a {} -d {}\n", verb.name, quoted(verb.summary));
    const std::string here = fmt::format("complete -c tumble -n '__fish_seen_subcommand_from {}'", verb.name);
    if (const auto words = first_words_of(verb); !words.empty())
      text += fmt::format("{} -a {}\n", here, quoted(fmt::format("{}", fmt::join(words, " "))));
    for (const auto& argument : verb.arguments) {
      const auto values = values_of(verb, argument);
      const std::string accepted =
          values.empty() ? "" : fmt::format(" -x -a {}", quoted(fmt::format("{}", fmt::join(values, " "))));
      for (const auto& name : names_of(argument))
        text += fmt::format("{} {} {}{} -d {}\n", here, name.starts_with("--") ? "-l" : "-s",
                            name.substr(name.starts_with("--") ? 2 : 1), accepted, quoted(argument.description));
    }
  }
  return text;
}

/// A line of a manual page: a dot at its beginning would be a command, a hyphen a dash.
std::string roff(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = i == 0 || text[i - 1] == '\n';
    if (begins && (text[i] == '.' || text[i] == '\'')) result += "\\&";
    if (text[i] == '-' || text[i] == '\\')
      result += text[i] == '-' ? "\\-" : "\\e";
    else
      result += text[i];
  }
  return result;
}

std::string manual(const std::vector<Verb>& verbs) {
  std::string text =
      ".TH TUMBLE 1\n.SH NAME\ntumble \\- identify inertial instruments: from a plan and recordings to parameters with "
      "uncertainty\n.SH SYNOPSIS\n.B tumble\nVERB [OPTIONS]\n.SH VERBS\n";
  for (const auto& verb : verbs) {
    text += fmt::format(".SS tumble {}\n{}.\n", verb.name, roff(verb.summary));
    for (const auto& argument : verb.arguments)
      text += fmt::format(".TP\n.B {}\n{}\n", roff(argument.name), roff(argument.description));
    text += fmt::format(".PP\n.nf\n{}.fi\n", roff(verb.footer));
  }
  return text +
         ".SH EXIT STATUS\n.TP\n.B 0\ndone\n.TP\n.B 1\na limit failed or could not be decided (\\-\\-strict)\n.TP\n"
         ".B 2\nthe command line or the plan is wrong\n.TP\n.B 3\na recording or file is wrong\n.TP\n.B 4\na defect of "
         "the program\n";
}

}  // namespace

Verb completion_verb(const std::vector<Verb>& verbs) {
  auto kind = std::make_shared<std::string>();
  return {"completion",
          "Print the words for a shell, or the manual page",
          {{.name = "SHELL",
            .value = kind.get(),
            .description = "bash, zsh or fish; man: the manual page",
            .required = true,
            .words = {"bash", "zsh", "fish", "man"}}},
          "Examples:\n"
          "  source <(tumble completion bash)\n"
          "  tumble completion fish > ~/.config/fish/completions/tumble.fish\n",
          [kind, verbs](const Terminal&) {
            print(*kind == "bash"   ? bash(verbs)
                  : *kind == "zsh"  ? zsh(verbs)
                  : *kind == "fish" ? fish(verbs)
                                    : manual(verbs));
            return 0;
          }};
}

}  // namespace tumble::cli
