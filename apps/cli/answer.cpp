#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/desk/run_desk.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/station/typed_order.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct AnswerArguments {
  std::string run, word, who;
};

std::optional<Prompt> open_question(const nlohmann::json& state) {
  if (!state.contains("view") || !state["view"].is_object() || !state["view"].contains("prompt")) return std::nullopt;
  const nlohmann::json& open = state["view"]["prompt"];
  Prompt prompt;
  prompt.id = open.at("id");
  const std::string text = open.at("text");  // all that the desk of an earlier version says
  prompt.text = open.contains("text_said") ? sentence_from_json(open["text_said"].dump()) : Sentence(text);
  prompt.choices = open.at("choices").get<std::vector<std::string>>();
  prompt.standard = open.at("standard");
  return prompt;
}

/// What is to be sent to the run for what would be typed at its own terminal.
nlohmann::json request_of(const decltype(RunEvent::what)& order, const std::string& who) {
  if (const auto* answer = std::get_if<PromptAnswer>(&order))
    return {{"order", "answer"}, {"prompt", answer->prompt}, {"choice", answer->choice}, {"who", who}};
  return {{"order", desk_word(std::get<RunOrder>(order).kind)}, {"who", who}};
}

Sentence question_text(const Prompt& prompt) {
  return say("{}\n  answer one of: {} (standard: {})\n", prompt.text, fmt::join(prompt.choices, ", "),
             Name{prompt.standard});
}

Sentence state_text(const nlohmann::json& state) {
  if (!state["view"].is_object()) return "the run is being prepared\n";
  const nlohmann::json& view = state["view"];
  return say("{}  {}  segment {} of {} '{}', {} left\n", Name{view.value("time_text", "")},
             Name{view.value("phase", "")},
             std::min(view.value("segment", 0) + 1, static_cast<int>(view["segments"].size())), view["segments"].size(),
             view.value("label", ""), Name{view.value("left_text", "")});
}

int run(const AnswerArguments& arguments, const Terminal& terminal) {
  const nlohmann::json state = nlohmann::json::parse(ask_desk(arguments.run, R"({"ask":"state"})"));
  const auto open = open_question(state);
  if (arguments.word.empty()) {
    print_said(terminal, state_text(state));
    print_said(terminal, open ? question_text(*open) : Sentence("no question is open\n"));
    return 0;
  }
  if (arguments.who.empty())
    throw Error(Error::Kind::bad_input, "--operator: an answer needs the name of who gives it");
  const auto order = order_of_line(arguments.word, open, arguments.who);
  if (!order)
    throw Error(Error::Kind::bad_input,
                say("'{}' means nothing to the run now: pause, resume or abort is expected{}", arguments.word,
                    open ? say(", or an answer: {}", fmt::join(open->choices, ", ")) : Sentence()));
  ask_desk(arguments.run, request_of(*order, arguments.who).dump());
  print_said(terminal, say("the run has '{}' from {}\n", arguments.word, Name{arguments.who}));
  return 0;
}

}  // namespace

Verb answer_verb() {
  auto arguments = std::make_shared<AnswerArguments>();
  return {
      "answer",
      "Answer the question of a run, pause it or let it go on, from another terminal",
      {{"RUN", &arguments->run, "folder of the run", true},
       {"ANSWER", &arguments->word,
        "what would be typed at the terminal of the run: an answer to its question, pause, resume or abort; without "
        "it the state and the open question are shown"},
       {"--operator", &arguments->who, "who answers"}},
      "Examples:\n"
      "  tumble answer run-0173\n"
      "  tumble answer run-0173 done --operator \"Li Wei\"\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
