#include "tumble/station/typed_order.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

const Prompt question{.id = 7, .text = "Turn the instrument", .choices = {"done", "stop"}, .standard = "done"};

TEST(TypedOrder, AnswersTheOpenQuestionByItsWords) {
  for (const auto& [line, choice] : {std::pair{"done", "done"}, {"stop", "stop"}, {"", "done"}}) {
    const auto order = order_of_line(line, question, "Li");
    ASSERT_TRUE(order && std::holds_alternative<PromptAnswer>(*order)) << line;
    EXPECT_EQ(std::get<PromptAnswer>(*order).prompt, 7);
    EXPECT_EQ(std::get<PromptAnswer>(*order).choice, choice);
    EXPECT_EQ(std::get<PromptAnswer>(*order).who, "Li");
  }
}

TEST(TypedOrder, ATypingErrorIsNoAnswer) { EXPECT_FALSE(order_of_line("don", question, "Li")); }

TEST(TypedOrder, AbortEndsTheRunWhileAQuestionIsOpenToo) {
  for (const std::optional<Prompt>& open : {std::optional<Prompt>(), std::optional(question)}) {
    const auto order = order_of_line("abort", open, "Li");
    ASSERT_TRUE(order && std::holds_alternative<RunOrder>(*order));
    EXPECT_EQ(std::get<RunOrder>(*order).kind, RunOrder::Kind::abort);
  }
}

TEST(TypedOrder, AnEmptyLineMeansNothingWithoutAQuestion) {
  EXPECT_FALSE(order_of_line("", std::nullopt, "Li"));
  EXPECT_FALSE(order_of_line("done", std::nullopt, "Li"));
}

TEST(DeskOrder, EachWordIsFoundAgain) {
  using Kind = RunOrder::Kind;
  for (const Kind kind : {Kind::pause_at_checkpoint, Kind::resume, Kind::stop, Kind::abort})
    EXPECT_EQ(find_order(desk_word(kind)), kind);
  EXPECT_EQ(desk_word(Kind::start), "");
  EXPECT_FALSE(find_order(""));
}

}  // namespace
}  // namespace tumble
