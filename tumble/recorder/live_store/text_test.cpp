#include "tumble/recorder/live_store/text.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace tumble::live_store {
namespace {

struct Read {
  bool whole = false;
  std::optional<RunRow> row;
  std::optional<StoreEvent> event;
};

Read read(StoreItem::Kind kind, const std::string& body) {
  Read out;
  out.whole = items_of_text({.kind = kind, .first = 7, .begin = 12.5, .body = body}, [&](const StoreItem& item) {
    EXPECT_EQ(item.sequence, 7u);
    EXPECT_EQ(item.time, 12.5);
    EXPECT_EQ(item.kind == StoreItem::Kind::journal, item.journal != nullptr);
    if (item.journal) out.row = *item.journal;
    if (item.event) out.event = *item.event;
  });
  return out;
}

RunRow end_of_attempt() {
  RunRow row{.kind = RunRow::Kind::segment_ends, .time = 12.0, .segment = 2, .attempt = 3, .label = "up"};
  row.ending = RunRow::Ending::complete, row.rule = "sd(bias) <= 1 deg/h", row.reached = 130.0;
  row.demanded = {{"table.rate", 0.5}};
  return row;
}

TEST(StoreText, RowsAndEventsComeBack) {
  Chunk chunk{.kind = StoreItem::Kind::journal};
  put_journal(chunk, 7, 12.5, end_of_attempt());
  EXPECT_EQ(read(StoreItem::Kind::journal, chunk.body).row, end_of_attempt());
  Chunk event{.kind = StoreItem::Kind::event};
  put_event(event, 7, {12.5, EventKind::phase, "", "holding -> paused", "", RunPhase::paused});
  const auto back = read(StoreItem::Kind::event, event.body).event;
  ASSERT_TRUE(back);
  EXPECT_EQ(back->kind, EventKind::phase);
  EXPECT_EQ(back->phase, RunPhase::paused);
}

TEST(StoreText, SentencesComeBackWithTheirValues) {
  const Sentence lost = say("the link to {} is lost: {}", Name{"servo"}, Sentence("the other side closed the link"));
  Chunk event{.kind = StoreItem::Kind::event};
  put_event(event, 7, {12.5, EventKind::link, "", lost, ""});
  const auto back = read(StoreItem::Kind::event, event.body).event;
  ASSERT_TRUE(back && back->text.values.size() == 2);
  EXPECT_EQ(back->text, lost);
  EXPECT_EQ(back->text.pattern, "the link to {} is lost: {}");
  EXPECT_EQ(back->text.values[0].kind, SentenceValue::Kind::name);
  ASSERT_EQ(back->text.values[1].nested.size(), 1u);
  RunRow row = end_of_attempt();
  row.reason = lost;
  Chunk chunk{.kind = StoreItem::Kind::journal};
  put_journal(chunk, 7, 12.5, row);
  const auto read_row = read(StoreItem::Kind::journal, chunk.body).row;
  ASSERT_TRUE(read_row);
  EXPECT_EQ(read_row->reason.pattern, lost.pattern);
  EXPECT_EQ(read_row->reason, lost);
}

// There each end of an attempt stands twice, as a step of the recorder and as an event with the row.
TEST(StoreText, ReadsStoresOfVersion1) {
  const Read records =
      read(StoreItem::Kind::journal, R"({"attempt":3,"index":2,"run":1,"segment":"up","step":"records"})");
  ASSERT_TRUE(records.row);
  EXPECT_EQ(records.row->kind, RunRow::Kind::records);
  EXPECT_EQ(records.row->segment, 2u);
  EXPECT_EQ(records.row->attempt, 3);
  EXPECT_EQ(records.row->label, "up");
  const Read ends =
      read(StoreItem::Kind::journal, R"({"attempt":3,"finished":true,"index":2,"run":1,"segment":"up","step":"ends"})");
  EXPECT_TRUE(ends.whole);
  EXPECT_FALSE(ends.row);
  const std::string row = text_of(end_of_attempt());
  EXPECT_EQ(read(StoreItem::Kind::event, R"({"kind":"journal","more":)" + row + R"(,"text":"up"})").row,
            end_of_attempt());
  const Read phase = read(StoreItem::Kind::event, R"({"kind":"phase","text":"stopping -> faulted"})");
  ASSERT_TRUE(phase.event);
  EXPECT_EQ(phase.event->phase, RunPhase::faulted);
}

TEST(StoreText, AWordOfAnotherVersionIsAnotherEvent) {
  const auto event = read(StoreItem::Kind::event, R"({"kind":"weather","text":"it rains"})").event;
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, EventKind::other);
  EXPECT_EQ(event->text, "it rains");
  EXPECT_EQ(event->text.pattern, "{}")
      << "a store of version 1 has texts alone: no language changes them by their values";
  EXPECT_FALSE(read(StoreItem::Kind::journal, R"({"kind":99})").whole);
}

TEST(RunRow, EveryWordOfAnEventIsFoundAgain) {
  for (int k = 0; k <= static_cast<int>(EventKind::other); ++k)
    EXPECT_EQ(event_kind(name(static_cast<EventKind>(k))), static_cast<EventKind>(k));
  EXPECT_EQ(name(EventKind::link_lost), "link lost");
  for (const auto ending : {RunEnding::complete, RunEnding::aborted, RunEnding::stopped, RunEnding::failed,
                            RunEnding::error, RunEnding::faulted})
    EXPECT_EQ(name(row_ending(ending)), name(ending));
}

}  // namespace
}  // namespace tumble::live_store
