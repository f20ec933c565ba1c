#include <fmt/format.h>

#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

namespace {

Problem problem_of(const FrameVector& vector, Problem problem) {
  return within(vector.place, within(Where{.table = "vector", .place = "[[vector]]"}, std::move(problem)));
}

void compare_values(const FrameCodec& codec, const FrameVector& vector, const FrameContent& content,
                    Problems& problems) {
  const auto differs = [&](const std::string& what, const std::string& is, const std::string& should) {
    problems.push_back(problem_of(vector, say("{} is {}, and should be {}", Name{what}, Name{is}, Name{should})));
  };
  for (std::size_t i = 0; i < codec.channels.size(); ++i) {
    const FrameChannel& channel = codec.channels[i];
    const auto wanted = vector.values.find(channel.name);
    if (wanted == vector.values.end()) continue;
    const double value = content.values[i], tolerance = wanted->second.tolerance + 1e-12 * std::abs(value);
    const auto said = [&](double si) {
      return channel.increment ? fmt::format("{:.9g} (SI)", si)
                               : fmt::format("{:.9g} {}", channel.unit.from_si(si), channel.unit.text());
    };
    if (!content.present[i] || !(std::abs(value - wanted->second.si) <= tolerance))
      differs(channel.name, content.present[i] ? said(value) : "not in the frame", said(wanted->second.si));
  }
  if (vector.counter && content.counter != vector.counter)
    differs("the counter", content.counter ? std::to_string(*content.counter) : "absent",
            std::to_string(*vector.counter));
  if (vector.time && !(content.time && std::abs(*content.time - vector.time->si) <= vector.time->tolerance + 1e-9))
    differs("the time", content.time ? fmt::format("{:.9g} s", *content.time) : "absent",
            fmt::format("{:.9g} s", vector.time->si));
}

}  // namespace

Problems problems_of_vectors(const FrameCodec& codec) {
  Problems problems;
  for (const FrameVector& vector : codec.vectors) {
    const auto content = decode_frame(codec, vector.bytes);
    if (!content) {
      problems.push_back(
          problem_of(vector, "its bytes are not a whole frame of this declaration whose checksum holds"));
      continue;
    }
    compare_values(codec, vector, *content, problems);
    try {
      if (encode_frame(codec, *content, vector.bytes) != vector.bytes)
        problems.push_back(problem_of(vector, "its values, encoded again, do not give its bytes"));
    } catch (const Error& error) {
      for (const auto& problem : error.problems) problems.push_back(problem_of(vector, problem));
    }
  }
  return problems;
}

std::string_view name(FrameCertainty certainty) {
  switch (certainty) {
    case FrameCertainty::maker:
      return "maker";
    case FrameCertainty::crossed:
      return "crossed";
    case FrameCertainty::driver:
      return "driver";
    case FrameCertainty::computed:
      return "computed";
    case FrameCertainty::uncertain:
      return "uncertain";
  }
  return "";
}

}  // namespace tumble
