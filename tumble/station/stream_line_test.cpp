#include "tumble/station/conduct/stream_line.hpp"

#include <gtest/gtest.h>

#include <string>

namespace tumble {
namespace {

const FrameLink three_commands{.start = {{"one\n", "ok 1"}, {"two\n", ""}, {"three\n", "ok 3"}},
                               .stop = {{"halt\n", ""}}};

struct HeardLine {
  std::string sent;
  conduct::StreamLine line{three_commands, [this](std::string_view bytes) { sent += bytes; }, 2.0};
};

TEST(StreamLine, SendsTheNextCommandWhenTheOneBeforeIsAnswered) {
  HeardLine one;
  one.line.start(0.0);
  EXPECT_EQ(one.sent, "one\n");
  EXPECT_FALSE(one.line.receive("..garbage..ok", false, 0.1));
  EXPECT_EQ(one.sent, "one\n");
  EXPECT_FALSE(one.line.receive(" 1\r\n", false, 0.2)) << "the answer may come in pieces";
  EXPECT_EQ(one.sent, "one\ntwo\nthree\n");
  EXPECT_FALSE(one.line.receive("ok 3", true, 0.3)) << "this frame may be from before";
  EXPECT_TRUE(one.line.answered());
  EXPECT_TRUE(one.line.receive("frame", true, 0.4));
  EXPECT_FALSE(one.line.receive("frame", true, 0.5)) << "it is said once";
  EXPECT_EQ(one.line.at(1e9), "");
}

TEST(StreamLine, BeginsAgainWhereAnAnswerOrAFrameIsMissing) {
  HeardLine one;
  one.line.start(0.0);
  one.line.receive("no", false, 1.0);
  EXPECT_EQ(one.line.at(1.9), "");
  EXPECT_EQ(one.line.at(2.0), "the instrument did not answer 'one.' with 'ok 1' within 2 s, but with 2 bytes: 'no'");
  EXPECT_EQ(one.sent, "one\none\n");
  one.line.receive("ok 1ok 3", false, 2.5);
  one.line.receive("ok 3", false, 2.6);
  EXPECT_EQ(one.line.at(4.7), "no frame came within 2 s after the commands that start the stream");
  EXPECT_EQ(one.sent, "one\none\ntwo\nthree\none\n");
  one.line.stop();
  EXPECT_EQ(one.sent, "one\none\ntwo\nthree\none\nhalt\n");
  EXPECT_FALSE(one.line.receive("frame", true, 5.0));
}

}  // namespace
}  // namespace tumble
